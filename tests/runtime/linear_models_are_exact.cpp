#include <gtest/gtest.h>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// Responses of the runtime at one node.
struct Answer {
  Eigen::Vector3d force;
  Points u;
  int force_status, deform_status;
};

Answer answer(const LoadedModel& loaded, std::int32_t node, const Eigen::Vector3d& d) {
  Answer a{{}, Points(info_of(loaded.model).n_output, 3), 0, 0};
  a.force_status = phn_force(loaded.model, loaded.data, AtNode(node, d.data()), a.force.data(), nullptr, nullptr);
  a.deform_status = phn_deform(loaded.model, loaded.data, AtNode(node, d.data()), a.u.data());
  return a;
}

// Claim: force is K d, deformation the sum of unit responses, prescribed nodes move by their weight times d,
// at any depth. 1e-15 of the sizes of the terms is the rounding of three products.
TEST(LinearRuntime, EqualsHostEvaluation) {
  const Model model = small_linear_model();
  const LoadedModel loaded(write_model_text(model));
  for (const ActiveNodeModel& node : model.nodes)
    for (const Eigen::Vector3d& d :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.004, -0.002, 0.001), Eigen::Vector3d(-30, 0.1, 7)}) {
      const Answer a = answer(loaded, node.node, d);
      EXPECT_LE((a.force - node.linear.stiffness * d).norm(), 1e-15 * 100 * d.norm());
      for (Eigen::Index o = 0; o < a.u.rows(); ++o) {
        const Eigen::Matrix3d axes = Eigen::Map<const Eigen::Matrix3d>(node.linear.unit_responses.row(o).data());
        EXPECT_LE((a.u.row(o).transpose() - axes * d).norm(), 2e-15 * d.norm());
        for (std::size_t i = 0; i < node.prescribed.size(); ++i)
          if (node.prescribed[i] == model.output[static_cast<std::size_t>(o)]) {
            EXPECT_EQ(a.u.row(o).transpose(), node.prescribed_weight[i] * d);
          }
      }
    }
}

// Claim: a linear model has no outside: far beyond the trained depth nothing warns of it, whatever else is
// warned of; the trained depth is told all the same.
TEST(LinearRuntime, HasNoOutside) {
  const LoadedModel loaded(write_model_text(small_linear_model()));
  const Eigen::Vector3d far(0.002, 50, 0);
  EXPECT_EQ(answer(loaded, 3, far).force_status, PHN_OK);
  EXPECT_EQ(answer(loaded, 3, far).deform_status, PHN_OK);
  EXPECT_EQ(answer(loaded, 5, far).force_status, PHN_WARNING_INCOMPLETE);
  const Trained trained(loaded.model, 5, far.data());
  EXPECT_EQ(trained.status, PHN_OK);
  EXPECT_EQ(trained.depth, 0.005);
}

}  // namespace
