#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Vector3d;

// Gauss-Legendre points and weights on [-1, 1], ten points.
constexpr double gauss_point[] = {0.14887433898163121, 0.43339539412924719, 0.67940956829902441, 0.86506336668898451,
                                  0.97390652851717172};
constexpr double gauss_weight[] = {0.29552422471475287, 0.26926671930999636, 0.21908636251598204, 0.14945134915058059,
                                   0.06667134430868814};

// Claim: forces around closed polygons of 3 to 6 corners do no work, relative to the largest energy stored on the way,
// for every node of a model. Ten points on each eighth of an edge integrate exactly but for 4e-15 (halving the pieces
// changes nothing, doubling gives 1e-9), so the rest is rounding: found 4e-15, 1e-12 is what is asked for.
TEST(ClosedLoops, DoNoWork) {
  constexpr int n_parts = 8;
  const Model model = small_modal_model();
  const LoadedModel loaded(write_model_text(model));
  for (const ActiveNodeModel& node : model.nodes) {
    Numbers numbers;
    for (int loop = 0; loop < 1000; ++loop) {
      std::vector<Vector3d> corners(3 + static_cast<std::size_t>(loop % 4));
      for (Vector3d& corner : corners) corner = model.max_displacement_m * numbers.vector();
      double work = 0, stored = 0, energy = 0;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vector3d step = (corners[(i + 1) % corners.size()] - corners[i]) / n_parts;
        for (int part = 0; part < n_parts; ++part) {
          const Vector3d middle = corners[i] + (part + 0.5) * step;
          EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, middle.data()), nullptr, &energy, nullptr),
                    0);
          stored = std::max(stored, energy);
          for (int p = 0; p < 5; ++p)
            for (const double t : {gauss_point[p], -gauss_point[p]}) {
              const Vector3d d = middle + t / 2 * step;
              Vector3d force;
              EXPECT_GE(
                  phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force.data(), nullptr, nullptr), 0);
              work += gauss_weight[p] / 2 * force.dot(step);
            }
        }
      }
      EXPECT_LT(std::abs(work), 1e-12 * stored) << node.node << " " << loop;
    }
  }
}

}  // namespace
