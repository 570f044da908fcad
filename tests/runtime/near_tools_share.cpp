// Two tools of a body that come near to each other: no force grows without limit, and it stays that of an energy.
#include <gtest/gtest.h>
#include <phynness/phynness.hpp>

#include <Eigen/Dense>
#include <phynness/formats/body.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <vector>

#include "../block_body.hpp"
#include "loaded_body.hpp"

namespace phynness::test {
namespace {

/// Two tools on the top of a block, around its middle, with their separation along x.
struct Pair {
  static constexpr double radius = block_radius;
  phn_tool tool(double x, const Eigen::Vector3d& displacement) const {
    return tool_at(nearest_on_surface(block.mesh.nodes, block.mesh.surface, {0.06 + x, 0.06, 0.03}), displacement);
  }
  /// @param separation  in radii
  int press(double separation, const Eigen::Vector3d& a, const Eigen::Vector3d& b, int steps = 100) {
    return body.press({tool(-separation * radius / 2, a), tool(separation * radius / 2, b)}, steps);
  }
  double alone(const Eigen::Vector3d& displacement) {
    EXPECT_EQ(body.press({tool(0, displacement)}, 100), PHN_OK);
    return forces[0].norm();
  }
  double larger() const { return std::max(forces[0].norm(), forces[1].norm()); }

  Block block;
  LoadedBody body{write_body_text(block.body)};
  const std::array<Eigen::Vector3d, 3>& forces = body.force;
};

const Eigen::Vector3d push(0, 0, -0.3 * block_depth), pull(0, 0, 0.3 * block_depth);

/// Separation in radii from which on there are no springs.
constexpr double reach = 0.5;
int expected_status(double separation) { return separation < reach ? PHN_WARNING_NEAR : PHN_OK; }

// Claim: two tools with the same push share the force of one where they meet, and at no separation has one of them
// more than a small multiple of it. Wherever springs join them there is a warning, because the shares are not known.
TEST(NearTools, ShareTheForceOfOne) {
  Pair pair;
  const double alone = pair.alone(push);
  ASSERT_EQ(pair.press(0, push, push), PHN_WARNING_NEAR);
  EXPECT_NEAR(pair.forces[0].norm(), alone / 2, 1e-3 * alone);
  EXPECT_NEAR(pair.forces[1].norm(), alone / 2, 1e-3 * alone);
  for (double separation = 1e-4; separation < 1; separation = 1.2 * separation + 0.01) {
    ASSERT_EQ(pair.press(separation, push, push), expected_status(separation)) << separation;
    // The pair is stiffest where the springs end: there it has the tilt of the surface between the tools to undo, which
    // is hard to do for edges of 0.9 radii. Without springs it is 35 times that of one at 0.05 radii.
    EXPECT_LT(pair.larger(), 6 * alone) << separation;
  }
}

// Claim: tools that are opposed at one place have five times the force of each alone, which is the compliance of the
// springs, with a warning; without springs the force would have no limit.
TEST(NearTools, OpposedHaveTheForceOfTheSprings) {
  Pair pair;
  const double alone = pair.alone(push);
  EXPECT_EQ(pair.press(0, push, pull), PHN_WARNING_NEAR);
  // Of a nonlinear body alone the force is not exactly that at rest, to which the springs belong.
  EXPECT_NEAR(pair.forces[0].norm(), 5 * alone, 0.5 * alone);
  EXPECT_NEAR((pair.forces[0] + pair.forces[1]).norm(), 0, 1e-3 * alone);
  for (double separation = 0.01; separation < 0.6; separation += 0.02) {
    EXPECT_EQ(pair.press(separation, push, pull), expected_status(separation)) << separation;
    EXPECT_LT(pair.body.pressed.residual_m, 1e-3 * block_depth) << separation;
  }
  // The body stays at rest, and all energy is that of the springs.
  for (const double depth : {0.01, 0.1, 1.0}) {
    const Eigen::Vector3d deep(0, 0, -depth * block_depth);
    ASSERT_EQ(pair.press(0, deep, -deep), PHN_WARNING_NEAR) << depth;
    EXPECT_NEAR(pair.forces[0].dot(deep) - pair.forces[1].dot(deep), 2 * pair.body.pressed.energy,
                1e-4 * pair.body.pressed.energy)  // steps end by the rounding of the energies of cells
        << depth;
  }
}

// Claim: forces are the derivatives of the energy, which has that of the springs.
TEST(NearTools, HaveAnEnergy) {
  Pair pair;
  const Eigen::Vector3d a(0.1 * block_depth, 0, -0.3 * block_depth), b(-0.1 * block_depth, 0, 0.1 * block_depth);
  constexpr double h = 1e-3 * block_depth;  // the error is of its square, and rounding far below
  for (const double separation : {0.0, 0.1, 0.3, 0.45})
    expect_forces_of_an_energy(
        pair.body, {a, b}, h, [&](const auto& x, const auto& y) { return pair.press(separation, x, y); }, separation);
}

// Claim: in an approach with one step in each millisecond at 50 mm/s the force of a settled pair changes by at most 5 %
// of the largest from one to the next, and the pair leaves on the way that it came.
TEST(NearTools, ApproachWithoutAJump) {
  Pair pair;
  for (const Eigen::Vector3d& other : {push, pull}) {
    std::vector<Eigen::Vector3d> coming;
    double largest = 0, change = 0, apart = 0;
    int unsettled = 0, last = 0;
    ASSERT_GE(pair.press(1.2, push, other), PHN_OK);
    constexpr int n = static_cast<int>(1.2 * block_radius / 5e-5);
    for (int moment = 0; moment <= 2 * n; ++moment) {
      const double separation = 1.2 * std::abs(1 - static_cast<double>(moment) / n);
      const Eigen::Vector3d before = pair.forces[0];
      const int status = pair.press(separation, push, other, 1) & PHN_WARNING_UNSETTLED;
      unsettled += status != 0;
      largest = std::max(largest, pair.larger());
      if (status == 0 && last == 0) change = std::max(change, (pair.forces[0] - before).norm());
      last = status;
      if (moment <= n) coming.push_back(pair.forces[0]);
      if (moment > n && status == 0)
        apart = std::max(apart, (pair.forces[0] - coming[static_cast<std::size_t>(2 * n - moment)]).norm());
    }
    EXPECT_LT(unsettled, n / 50);
    EXPECT_LT(change, 0.05 * largest);
    EXPECT_LT(apart, 0.05 * largest);
  }
}

// Claim: spheres that press side by side, come near until they are at one place and leave again, at 20 mm/s each with
// one step in each millisecond, have forces that change by at most 5 % of the largest from one to the next, and at one
// place they share the force of one.
TEST(NearTools, SpheresShareWithoutAJump) {
  const Block block;
  const std::string text = write_body_text(block.body);
  constexpr double radius = 0.01, depth = 0.3 * block_depth, step = 2e-5;
  for (const double friction : {0.0, 0.5}) {
    Organ organ({}, text, 2);
    ASSERT_TRUE(organ);
    double largest = 0, change = 0, jump_at = 0, together = 0;
    Eigen::Vector3d last[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    const auto sphere = [&](double x, double deep) {
      return phn_contact_tool{{0.06 + x, 0.061, 0.03 + radius - deep}, radius, friction, PHN_TOOL_PRESS};
    };
    const auto move = [&](double separation, double deep) {
      const phn_contact_tool spheres[] = {sphere(-separation / 2, deep), sphere(separation / 2, deep)};
      phn_contact_state states[2];
      ASSERT_GE(organ.touch({spheres, 2}, {states, 2}), 0);
      for (int t = 0; t < 2; ++t) {
        const Eigen::Vector3d force(states[t].force);
        largest = std::max(largest, force.norm());
        if ((force - last[t]).norm() > change) jump_at = separation;
        change = std::max(change, (force - last[t]).norm());
        last[t] = force;
      }
    };
    constexpr double apart = 0.6 * block_radius;
    for (double deep = -0.001; deep < depth; deep += step) move(apart, deep);
    for (double separation = apart; separation > 0; separation -= step) move(separation, depth);
    together = (last[0] + last[1]).norm();
    EXPECT_NEAR(last[0].norm(), last[1].norm(), 0.2 * together);
    for (double separation = 0; separation < apart; separation += step) move(separation, depth);
    for (double deep = depth; deep > -0.001; deep -= step) move(apart, deep);
    EXPECT_LT(change, 0.05 * largest) << friction << " at " << jump_at;
    EXPECT_EQ(last[0].norm() + last[1].norm(), 0);
    if (friction > 0) continue;
    Organ one({}, text);
    phn_contact_state state;
    for (double deep = -0.001; deep < depth; deep += step) {
      const phn_contact_tool alone = sphere(0, deep);
      ASSERT_GE(one.touch({&alone, 1}, {&state, 1}), 0);
    }
    EXPECT_NEAR(together, Eigen::Vector3d(state.force).norm(), 0.05 * together);
  }
}

}  // namespace
}  // namespace phynness::test
