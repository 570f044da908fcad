// Claims of formats/model.md where two rules could meet: w d at prescribed nodes wins over the modes of near nodes,
// also where such a node is fixed; of equally near directions the shorter one counts; a direction that was not
// requested has no trained range.
#include <gtest/gtest.h>

#include <phynness/phynness.h>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

TEST(Format, PrescribedNodesWinOverNearAndFixedOnes) {
  Model model = small_modal_model();
  // Node 2 is fixed and an output node, as with output = "all".
  model.fixed = {0, 1, 2};
  model.fixed_points.conservativeResize(3, 3);
  model.fixed_points.row(2) = model.output_points.row(0);
  auto& node = model.nodes[0];
  ASSERT_EQ(node.node, 3);
  ASSERT_EQ(node.modal.near.front(), 0);
  node.prescribed = {2, 3};
  node.prescribed_weight = {0.5, 1};
  const LoadedModel loaded(write_model_text(model));
  const double d[3] = {0.001, -0.002, 0.003};
  std::vector<double> u(3 * model.output.size());
  ASSERT_GE(phn_deform(loaded.model, loaded.data, AtNode(3, d), u.data()), 0);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(u[static_cast<std::size_t>(k)], 0.5 * d[k]);
    EXPECT_EQ(u[static_cast<std::size_t>(3 + k)], d[k]);
  }
}

TEST(Format, TheSmallerOfEquallyNearDirectionsCounts) {
  Model model = small_modal_model();
  model.nodes[0].trained_depth_m = {0.004, 0.007, 0, 0.009};
  const LoadedModel loaded(write_model_text(model));
  const auto depth = [&](double x, double y, double z) {
    const double d[3] = {x, y, z};
    const Trained trained(loaded.model, 3, d);
    EXPECT_GE(trained.status, 0);
    return trained.depth;
  };
  EXPECT_EQ(depth(0.001, 0.001, 0), 0.004);
  EXPECT_EQ(depth(0.001, 0.002, 0), 0.007);
  EXPECT_EQ(depth(0, 0.001, 0.001), 0);
  EXPECT_EQ(depth(0, 0, 0.001), 0);
  const double d[3] = {0, 0, 1e-6};
  double force[3];
  EXPECT_TRUE(phn_force(loaded.model, loaded.data, AtNode(3, d), force, nullptr, nullptr) & PHN_WARNING_OUTSIDE);
}

}  // namespace
