#include <gtest/gtest.h>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

const std::vector<std::int32_t> tools = {3, 8, 15};
const double displacements[] = {0.004, 0.001, 0, 0, -0.006, 0.002, 0.003, 0.003, -0.001};

Points deform(const LoadedModel& loaded, int n_tools, const std::int32_t* nodes, const double* d) {
  Points u(info_of(loaded.model).n_output, 3);
  EXPECT_GE(phn_blend_paper(loaded.model, loaded.data, n_tools, nodes, d, u.data()), 0);
  return u;
}

// Claim: away from the touched nodes the field is sum Theta_I U_I with Theta_I of (16), here computed as
// printed; U_I is the field of tool I alone. 1e-13 relative is rounding of a weighted sum.
TEST(SeveralTools, FieldIsTheWeightedSum) {
  const Model model = small_model();
  const LoadedModel loaded(write_model_text(model));
  const Points u = deform(loaded, 3, tools.data(), displacements);
  for (Eigen::Index o = 0; o < u.rows(); ++o) {
    Eigen::RowVector3d expected(0, 0, 0);
    double sum = 0;
    bool touched = false;
    for (int t = 0; t < 3; ++t) {
      const ActiveNodeModel& node = model.nodes[t == 0 ? 0 : t + 1];
      const Eigen::RowVector3d x(node.point[0], node.point[1], node.point[2]);
      const double distance = (model.output_points.row(o) - x).norm();
      touched = touched || distance == 0;
      sum += 1 / distance;
      expected += 1 / distance * deform(loaded, 1, &tools[t], displacements + 3 * t).row(o);
    }
    if (!touched) {
      EXPECT_LT((u.row(o) - expected / sum).norm(), 1e-13 * u.norm());
    }
  }
}

// Claim: where (16) is singular, at a touched node, that node takes exactly its own displacement.
TEST(SeveralTools, TouchedNodesFollowExactly) {
  const LoadedModel loaded(write_model_text(small_model()));
  const Points u = deform(loaded, 3, tools.data(), displacements);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(u(3 - 2, k), displacements[k]);
    EXPECT_EQ(u(8 - 2, k), displacements[3 + k]);
  }
}

// Claim: two tools at one node act as one with their mean displacement there. Rounding of a mean: 1e-15.
TEST(SeveralTools, AtOneNodeActAsTheirMean) {
  const LoadedModel loaded(write_model_text(small_model()));
  const std::int32_t twice[] = {3, 3};
  const Points u = deform(loaded, 2, twice, displacements);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(u(3 - 2, k), (displacements[k] + displacements[3 + k]) / 2, 1e-15);
}

// Claim: two nodes at one place (the lips of a slit) share the weight there instead of dividing by zero.
TEST(SeveralTools, CoincidentNodesAreDefined) {
  Model model = small_model(0, 0);
  model.nodes[1].point = model.nodes[0].point;
  model.output_points.row(3) = model.output_points.row(1);
  const LoadedModel loaded(write_model_text(model));
  const std::int32_t pair[] = {3, 5};
  EXPECT_TRUE(deform(loaded, 2, pair, displacements).allFinite());
}

// Claim: no tool, no displacement.
TEST(SeveralTools, NoToolLeavesTheObjectAtRest) {
  const LoadedModel loaded(write_model_text(small_model()));
  EXPECT_EQ(deform(loaded, 0, nullptr, nullptr).norm(), 0);
}

}  // namespace
