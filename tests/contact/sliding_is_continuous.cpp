#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

struct Largest {
  double force = 0, proxy = 0, field = 0;
  int n_triangles = 0;
};

/// Slides 60 degrees along a great circle in a plane that holds edges and nodes, or beside it, 3 mm deep.
Largest slide(const LoadedModel& loaded, double mu, double beside, int n_steps) {
  Touch touch(loaded);
  Largest most;
  phn_contact_state last = {};
  const auto place = [&](double turn, double depth) {
    return Vector3d((0.054 - depth) * std::sin(turn), beside, (0.054 - depth) * std::cos(turn));
  };
  touch.step(tool_at(place(-0.1, -0.005), 0.004, PHN_TOOL_PRESS, mu));
  for (int i = 0; i <= 20; ++i) last = touch.step(tool_at(place(-0.1, 0.003 * i / 20), 0.004, PHN_TOOL_PRESS, mu));
  for (int i = 1; i <= n_steps; ++i) {
    const auto state = touch.step(tool_at(place(-0.1 + 1.05 * i / n_steps, 0.003), 0.004, PHN_TOOL_PRESS, mu));
    EXPECT_EQ(state.in_contact, 1);
    most.force = std::max(most.force, (vector(state.force) - vector(last.force)).norm());
    most.proxy = std::max(most.proxy, (vector(state.proxy) - vector(last.proxy)).norm());
    most.n_triangles += !std::equal(state.held.nodes, state.held.nodes + 3, last.held.nodes);
    // The touched point follows the tool: fields of modal models are floats.
    if (i % (n_steps / 50) == 0)
      most.field = std::max(most.field, (touch.moved(state.held) - vector(state.held.displacement)).norm());
    last = state;
  }
  return most;
}

// Claim: while a tool slides over edges, along them and over nodes, force and proxy change by no more than in
// proportion to the step: 1/10 of the step, 1/10 of the largest change (1/6, as the tolerance of sliding,
// 1e-4 of 0.2 N, adds its part), and none is beyond some stiffnesses times the step. The touched point
// follows the tool to the accuracy of floats.
TEST(Sliding, JumpsShrinkWithTheStep) {
  for (const double mu : {0.0, 0.3})
    for (const double beside : {0.0, 1e-7, 0.0021}) {
      const int n = 500;
      const Largest coarse = slide(bent_ball(), mu, beside, n), fine = slide(bent_ball(), mu, beside, 10 * n);
      const double step = 0.051 * 1.05 / n;
      EXPECT_GE(coarse.n_triangles, 8);
      EXPECT_LT(coarse.force, 250 * step) << mu << " " << beside;
      EXPECT_LT(coarse.proxy, 4 * step) << mu << " " << beside;
      EXPECT_LT(fine.force, coarse.force / 6) << mu << " " << beside;
      EXPECT_LT(fine.proxy, coarse.proxy / 6) << mu << " " << beside;
      EXPECT_LT(coarse.field, 1e-8);
    }
}

// Claim: force is continuous where contact begins and ends: a touch a thousandth of a millimetre deep is felt
// by no more than the stiffness says.
TEST(Sliding, TouchesBeginAtZero) {
  Touch touch(bent_ball());
  Numbers numbers;
  for (int i = 0; i < 150; ++i) {
    phn_contact_reset(touch.contact);
    const Vector3d at = random_direction(numbers);
    double last = 0, largest = 0;
    for (int k = 0; k < 3000; ++k) {
      const auto state = touch.step(tool_at((0.0545 - 1e-6 * k) * at, 0.004));
      largest = std::max(largest, std::abs(vector(state.force).norm() - last));
      last = vector(state.force).norm();
      if (last > 0.005) break;
    }
    ASSERT_GT(last, 0.005);
    ASSERT_LT(largest, 250 * 1e-6);
  }
}

}  // namespace
