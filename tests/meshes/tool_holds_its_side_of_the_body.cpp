// Claims: a round tool moves the mean of the surface that is connected to its middle within its radius, and not the far
// side of a thin body; its weights are positive, have the sum 1 and on flat faces the tool's middle as their center;
// fixed nodes have none, and the sum is less beside them; the weights are continuous while the tool slides, also around
// the rim of a thin body; a part of the surface has the weight that a flat disc of its area in the tangent plane at the
// middle would have; integrals of linear and quadratic functions are those of a midpoint rule on small parts.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/schema/round_tool.hpp>

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

// Claim: a body is touched within the radius of a probed node, on its side, where it is not fixed; one of node probes
// at probed nodes alone.
TEST(TouchableNodes, AreThoseNearAProbedNodeOnItsSide) {
  const Slab slab;
  const std::int32_t fixed = 0, probed = slab.middle;
  const NodeSets sets{{fixed}, {probed}, {}};
  constexpr double radius = 0.0201;  // of two edges; the bottom is one away
  std::vector<std::int32_t> expected;
  for (std::int32_t i = 0; i < slab.mesh.n_nodes(); ++i)
    if (slab.mesh.nodes(i, 2) > 0.005 && (slab.mesh.nodes.row(i) - slab.mesh.nodes.row(probed)).norm() < radius)
      expected.push_back(i);
  EXPECT_EQ(expected.size(), 13U);  // of a square lattice within two edges
  EXPECT_EQ(touchable_nodes(slab.mesh, sets, radius), expected);
  EXPECT_EQ(touchable_nodes(slab.mesh, sets, 0), sets.active);
  const auto all = touchable_nodes(slab.mesh, sets, 1);
  EXPECT_FALSE(std::ranges::binary_search(all, fixed));
  EXPECT_GT(all.size(), 80U);  // the 81 nodes of the top, but perhaps a corner
}

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

/// Divisor of the weights that add up to `moving` without it, beside fixed nodes with the sum `fixed`, as theory.md
/// says.
double divisor_beside(double moving, double fixed) {
  const double ratio = fixed / moving;
  return moving * (1 + ratio / (1 + 1.5 * ratio));
}

TEST(RoundTool, LeavesFixedNodesAlone) {
  const Slab slab;
  const auto all = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, at_node(slab.middle), 0.02);
  const std::vector<std::int32_t> fixed{all.nodes.front()};
  const auto some = touched_nodes(slab.mesh.nodes, slab.mesh.surface, fixed, at_node(slab.middle), 0.02);
  ASSERT_EQ(some.nodes.size() + 1, all.nodes.size());
  for (std::size_t i = 0; i < some.nodes.size(); ++i) {
    EXPECT_EQ(some.nodes[i], all.nodes[i + 1]);
    EXPECT_NEAR(some.weights[i], all.weights[i + 1] / divisor_beside(1 - all.weights[0], all.weights[0]), 1e-14);
  }
  EXPECT_THROW(touched_nodes(slab.mesh.nodes, slab.mesh.surface, all.nodes, at_node(slab.middle), 0.02), Error);
}

TEST(RoundTool, DoesNotCountWhatIsFixedAltogether) {
  // Fixed are the nodes to x = 0.03. Triangles between them do not count, nodes at x = 0.03 count in part in the
  // others: the tool around x = 0.04 has the sum of the weights of its nodes beyond 0.03 over that sum and a part of
  // the half of the strip beside that belongs to nodes at 0.03. A tool that touches little that moves has at least 3/5
  // of its weights.
  const Slab slab;
  std::vector<std::int32_t> fixed;
  for (std::int32_t i = 0; i < slab.mesh.n_nodes(); ++i)
    if (slab.mesh.nodes(i, 0) < 0.031) fixed.push_back(i);
  const auto sum_of = [&](double x) {
    const auto place = nearest_on_surface(slab.mesh.nodes, slab.mesh.surface, {x, 0.04, 0.01});
    const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, fixed, place, 0.02);
    return std::accumulate(touched.weights.begin(), touched.weights.end(), 0.0);
  };
  for (const double center : {0.04, 0.02}) {
    // Over x > 0.03, in radii s = (x - center) / 0.02: chords 2 sqrt(1 - s^2), and (x - 0.03) / 0.01 up to x = 0.04 for
    // what moves.
    double moving = 0, fixed_part = 0;
    constexpr int n = 100000;
    const double first = (0.03 - center) / 0.02;
    for (int i = 0; i < n; ++i) {
      const double s = first + (1 - first) * (i + 0.5) / n, chord = std::sqrt(1 - s * s);
      const double moves = std::min(1.0, 2 * (s - first));
      moving += moves * chord;
      fixed_part += (1 - moves) * chord;
    }
    EXPECT_NEAR(sum_of(center), moving / divisor_beside(moving, fixed_part), 1e-6);
  }
  EXPECT_NEAR(sum_of(0.07), 1, 1e-14);
}

/// The largest change of a weight while the tool slides along a line on the surface in 200 steps.
double largest_change(const Slab& slab, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  double largest = 0;
  Eigen::VectorXd before;
  for (int step = 0; step <= 200; ++step) {
    const Eigen::Vector3d x = from + (to - from) * step / 200;
    const auto place = nearest_on_surface(slab.mesh.nodes, slab.mesh.surface, {x[0], x[1], x[2]});
    const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, place, 0.023);
    Eigen::VectorXd now = Eigen::VectorXd::Zero(slab.mesh.n_nodes());
    for (std::size_t i = 0; i < touched.nodes.size(); ++i) now[touched.nodes[i]] = touched.weights[i];
    if (step > 0) largest = std::max(largest, (now - before).cwiseAbs().maxCoeff());
    before = now;
  }
  return largest;
}

TEST(RoundTool, MovesContinuouslyOverTrianglesAndNodes) {
  // From node to node; a step of a two hundredth of an edge changes no weight by more than the largest slope allows.
  EXPECT_LT(largest_change(Slab(), {0.04, 0.041, 0.01}, {0.05, 0.041, 0.01}), 2e-3);
}

TEST(RoundTool, MovesContinuouslyTowardsTheRimOfAThinBody) {
  // Two edges, twice the steps of above. Where the radius reaches around the rim, the far face would enter at once.
  const Slab slab;
  EXPECT_LT(largest_change(slab, {0.055, 0.041, 0.01}, {0.075, 0.041, 0.01}), 4e-3);
}

TEST(RoundTool, PressesWhatFacesItAsAFlatDisc) {
  // On a ball of radius 1 a tool of radius R touches a cap whose projected area is pi s^2, s = sin of its angle, with
  // R = 2 sin(angle / 2). The mean of z over it, by projected area: (2 / s^2) int_0^s sqrt(1 - r^2) r dr.
  Mesh ball = block_mesh({24, 24, 24}, {2, 2, 2});
  for (Eigen::Index i = 0; i < ball.n_nodes(); ++i) {
    const Eigen::RowVector3d x = ball.nodes.row(i).array() - 1;
    ball.nodes.row(i) = x.cwiseAbs().maxCoeff() * x.normalized();
  }
  const double radius = 1, angle = 2 * std::asin(radius / 2), c = std::cos(angle), s2 = 1 - c * c;
  std::int32_t top = 0;
  (ball.nodes.rowwise() - Eigen::RowVector3d(0, 0, 1)).rowwise().squaredNorm().minCoeff(&top);
  const auto touched = touched_nodes(ball.nodes, ball.surface, {}, at_node(top), radius);
  double z = 0;
  for (std::size_t i = 0; i < touched.nodes.size(); ++i) z += touched.weights[i] * ball.nodes(touched.nodes[i], 2);
  // Chords of diagonals of 0.12 are up to 0.12^2 / 8 below the ball.
  EXPECT_NEAR(z, 2 / s2 * (1 - c * c * c) / 3, 2e-3);
}

TEST(RoundTool, DoesNotPressTheFarSideAroundARim) {
  const Slab slab;
  std::int32_t near_rim = 0;
  (slab.mesh.nodes.rowwise() - Eigen::RowVector3d(0.07, 0.04, 0.01)).rowwise().squaredNorm().minCoeff(&near_rim);
  double lowest = 1;
  for (const auto node : touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, at_node(near_rim), 0.025).nodes)
    lowest = std::min(lowest, slab.mesh.nodes(node, 2));
  EXPECT_EQ(lowest, 0.01) << "the side face is at right angles to the top";
}

TEST(RoundTool, OfRadiusZeroIsTheNodeOrTheCornersOfTheTriangle) {
  const Slab slab;
  const auto touched = touched_nodes(slab.mesh.nodes, slab.mesh.surface, {}, at_node(slab.middle), 0);
  EXPECT_EQ(touched.nodes, std::vector<std::int32_t>{slab.middle});
  EXPECT_EQ(touched.weights, std::vector<double>{1.0});
  EXPECT_FALSE(touched.mean);
}

/// Integrals over the part of a triangle in a ball by the midpoint rule on 512^2 parts.
std::array<double, 9> integrate_by_parts(const Eigen::Matrix3d& corners, const Eigen::Vector3d& x, double radius) {
  constexpr int n = 512;
  const double part = normal_of(corners).norm() / (2.0 * n * n);
  std::array<double, 9> sums{};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n - i; ++j)
      for (int down = 0; down < (i + j < n - 1 ? 2 : 1); ++down) {
        const double first = (i + (1 + down) / 3.0) / n, second = (j + (1 + down) / 3.0) / n;
        const double at[3] = {first, second, 1 - first - second};
        double squares = 0;
        for (int c = 0; c < 3; ++c)
          squares += std::pow(corners(c, 0) * at[0] + corners(c, 1) * at[1] + corners(c, 2) * at[2] - x[c], 2);
        if (squares >= radius * radius) continue;
        for (std::size_t k = 0; k < 3; ++k) {
          sums[k] += part * at[k] * (2 * at[k] - 1);
          sums[3 + k] += part * 4 * at[k] * at[(k + 1) % 3];
          sums[6 + k] += part * at[k];
        }
      }
  return sums;
}

TEST(RoundTool, IntegratesLinearAndQuadraticFunctions) {
  // A point of the border of a ball is in another part of a 512th of a corner's edges: below 1e-3 of the area.
  Eigen::Matrix3d corners;
  corners << 0, 1, 0.2, 0, 0.1, 0.9, 0, 0.3, -0.1;
  const Eigen::Vector3d area = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
  using schema::round_tool::Vector;
  const auto vector = [](const Eigen::Vector3d& v) { return Vector{{v[0], v[1], v[2]}}; };
  const Vector corner[3] = {vector(corners.col(0)), vector(corners.col(1)), vector(corners.col(2))};
  for (const auto& x : {Eigen::Vector3d(0.4, 0.3, 0.15), Eigen::Vector3d(-0.1, 0.2, 0), Eigen::Vector3d(0.9, 0.6, 0.1)})
    for (const double radius : {0.2, 0.5, 0.8, 3.0}) {
      double linear[3], quadratic[6];
      schema::round_tool::integrate(corner, vector(x), radius, vector(area.normalized()), linear);
      schema::round_tool::integrate(corner, vector(x), radius, vector(area.normalized()), quadratic);
      const auto sums = integrate_by_parts(corners, x, radius);
      for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(quadratic[k], sums[k], 1e-3 * area.norm()) << radius << " " << k;
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(linear[k], sums[6 + k], 1e-3 * area.norm()) << radius << " " << k;
      // Both sets have the sum 1, and a linear function is the sum of its values times the quadratic ones.
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(quadratic[k] + (quadratic[3 + k] + quadratic[3 + (k + 2) % 3]) / 2, linear[k], 1e-14);
    }
}

}  // namespace
}  // namespace phynness::test
