// Claim: a patch holds the surface nodes within its radius that are connected to its center over the surface, with the
// weights of the documented bump, and neither fixed nodes nor the far side of a thin body. The comparison is exact,
// because the expected weights are the same expression.
#include <gtest/gtest.h>

#include <cmath>
#include <phynness/formats/tool.hpp>

#include "../block_mesh.hpp"

namespace phynness::test {
namespace {

/// A slab of 8 x 8 x 1 boxes, 8 cm wide and 1 cm thick; the node in the middle of its top.
struct Slab {
  Mesh mesh = block_mesh({8, 8, 1}, {0.08, 0.08, 0.01});
  std::int32_t middle = 0;
  Slab() {
    const Eigen::RowVector3d wanted(0.04, 0.04, 0.01);
    (mesh.nodes.rowwise() - wanted).rowwise().squaredNorm().minCoeff(&middle);
  }
};

TEST(Patch, HoldsTheNearSideOfAThinBodyOnly) {
  const Slab slab;
  const double radius = 0.025;  // more than twice the thickness: a ball of it reaches the bottom as well
  const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, slab.middle, radius);
  std::size_t expected = 0, far_side = 0;
  for (std::int32_t i = 0; i < slab.mesh.n_nodes(); ++i) {
    const double s = (slab.mesh.nodes.row(i) - slab.mesh.nodes.row(slab.middle)).norm();
    if (s >= radius) continue;
    const bool top = slab.mesh.nodes(i, 2) > 0.005;
    ++(top ? expected : far_side);
    const auto at = std::find(touched.nodes.begin(), touched.nodes.end(), i);
    ASSERT_EQ(at != touched.nodes.end(), top) << "node " << i;
    if (!top) continue;
    EXPECT_NEAR(touched.weights[static_cast<std::size_t>(at - touched.nodes.begin())],
                std::pow(1 - s * s / (radius * radius), 2), 1e-14);
  }
  EXPECT_EQ(touched.nodes.size(), expected);
  EXPECT_GT(expected, 10u);
  EXPECT_GT(far_side, 5u) << "the far side is out of the ball: this test would show nothing";
}

TEST(Patch, LeavesFixedNodesAndTheRimAlone) {
  const Slab slab;
  const double spacing = 0.01;
  const auto all = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, slab.middle, 2 * spacing);
  // Nodes two spacings away lie on the rim, where the weight is zero however their distance is rounded.
  for (const auto i : all.nodes)
    EXPECT_LT((slab.mesh.nodes.row(i) - slab.mesh.nodes.row(slab.middle)).norm(), 1.9 * spacing);
  const std::vector<std::int32_t> fixed{all.nodes.front()};
  const auto some = touched_nodes(slab.mesh.nodes, slab.mesh.surface, fixed, slab.middle, 2 * spacing);
  EXPECT_EQ(some.nodes.size() + 1, all.nodes.size());
  EXPECT_EQ(std::count(some.nodes.begin(), some.nodes.end(), fixed[0]), 0);
}

TEST(Patch, OfRadiusZeroIsTheNodeAlone) {
  const Slab slab;
  const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, slab.middle, 0);
  EXPECT_EQ(touched.nodes, std::vector<std::int32_t>{slab.middle});
  EXPECT_EQ(touched.weights, std::vector<double>{1.0});
}

}  // namespace
}  // namespace phynness::test
