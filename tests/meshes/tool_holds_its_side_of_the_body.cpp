// Claims: a round tool moves the mean of the surface that is connected to its middle within its radius, and not the far
// side of a thin body; its weights are positive, have the sum 1 and the tool's middle as their center; fixed nodes have
// none; the weights are continuous while the tool slides.
#include <gtest/gtest.h>

#include <cmath>
#include <phynness/formats/error.hpp>
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

TEST(RoundTool, TouchesTheNearSideOfAThinBodyOnly) {
  const Slab slab;
  const double radius = 0.025;  // more than twice the thickness: a ball of it reaches the bottom as well
  const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, at_node(slab.middle), radius);
  EXPECT_TRUE(touched.mean);
  double sum = 0;
  Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
  for (std::size_t i = 0; i < touched.nodes.size(); ++i) {
    const Eigen::RowVector3d x = slab.mesh.nodes.row(touched.nodes[i]);
    EXPECT_GT(x[2], 0.005) << "node " << touched.nodes[i];
    EXPECT_GT(touched.weights[i], 0);
    sum += touched.weights[i];
    mean += touched.weights[i] * (x - slab.mesh.nodes.row(slab.middle));
  }
  EXPECT_NEAR(sum, 1, 1e-14);
  // Linear functions are reproduced; the rim is resolved to 0.004 radii.
  EXPECT_LT(mean.norm(), 1e-4 * radius);
  EXPECT_GT(touched.nodes.size(), 20u);
}

TEST(RoundTool, LeavesFixedNodesAlone) {
  const Slab slab;
  const auto all = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, at_node(slab.middle), 0.02);
  const std::vector<std::int32_t> fixed{all.nodes.front()};
  const auto some = touched_nodes(slab.mesh.nodes, slab.mesh.surface, fixed, at_node(slab.middle), 0.02);
  ASSERT_EQ(some.nodes.size() + 1, all.nodes.size());
  for (std::size_t i = 0; i < some.nodes.size(); ++i) {
    EXPECT_EQ(some.nodes[i], all.nodes[i + 1]);
    EXPECT_NEAR(some.weights[i], all.weights[i + 1] / (1 - all.weights[0]), 1e-14);
  }
  EXPECT_THROW(touched_nodes(slab.mesh.nodes, slab.mesh.surface, all.nodes, at_node(slab.middle), 0.02), Error);
}

TEST(RoundTool, MovesContinuouslyOverTrianglesAndNodes) {
  // From node to node; a step of a hundredth of an edge changes no weight by more than the largest slope allows.
  const Slab slab;
  std::vector<double> before;
  for (int step = 0; step <= 200; ++step) {
    const double x = 0.04 + 0.01 * step / 200;
    const auto place = nearest_on_surface(slab.mesh.nodes, slab.mesh.surface, {x, 0.041, 0.01});
    const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, place, 0.023);
    std::vector<double> now(static_cast<std::size_t>(slab.mesh.n_nodes()), 0.0);
    for (std::size_t i = 0; i < touched.nodes.size(); ++i)
      now[static_cast<std::size_t>(touched.nodes[i])] = touched.weights[i];
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(now[i], before[i], 2e-3) << "node " << i << " at " << x;
    before = now;
  }
}

TEST(RoundTool, OfRadiusZeroIsTheNodeOrTheCornersOfTheTriangle) {
  const Slab slab;
  const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, at_node(slab.middle), 0);
  EXPECT_EQ(touched.nodes, std::vector<std::int32_t>{slab.middle});
  EXPECT_EQ(touched.weights, std::vector<double>{1.0});
  EXPECT_FALSE(touched.mean);
}

}  // namespace
}  // namespace phynness::test
