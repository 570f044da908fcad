#include <gtest/gtest.h>

#include "closed_loop.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Vector3d;

// Claim: forces around a closed loop do no work, relative to the largest energy stored on the way, for every node of a
// model. Ten points on each eighth of an edge integrate exactly but for 4e-15 (halving the pieces changes nothing,
// doubling gives 1e-9), so the rest is rounding: found 4e-15 in double, 4e-8 in the runtime of floats; 1e-12 and 1e-5
// are what is asked for.
TEST(ClosedLoops, DoNoWork) {
  const Model model = small_modal_model();
  const LoadedModel loaded(write_model_text(model));
  const double R = model.max_displacement_m;
  for (const ActiveNodeModel& node : model.nodes) {
    EXPECT_LT(worst_loop(
                  [&](const Vector3d& x) {
                    const Vector3d d = R * x;
                    Vector3d force;
                    EXPECT_GE(phn_force(loaded.model, loaded.data, node.node, d.data(), force.data(), nullptr, nullptr),
                              0);
                    return Vector3d(R * force);
                  },
                  [&](const Vector3d& x) {
                    const Vector3d d = R * x;
                    double energy = 0;
                    EXPECT_GE(phn_force(loaded.model, loaded.data, node.node, d.data(), nullptr, &energy, nullptr), 0);
                    return energy;
                  }),
              1e-12);
  }
}

}  // namespace
