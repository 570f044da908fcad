#include <array>
#include <cmath>

#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

void expect_defined(const std::vector<phn_contact_state>& states, const std::vector<phn_contact_tool>& tools) {
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const Vector3d f = vector(states[t].force), n = vector(states[t].normal);
    ASSERT_TRUE(f.allFinite() && n.allFinite());
    if (!states[t].in_contact) {
      ASSERT_EQ(f.norm(), 0);
    }
    if (tools[t].mode != PHN_TOOL_PRESS) continue;
    ASSERT_LE(f.dot(n), 0);
    ASSERT_LE((f - f.dot(n) * n).norm(), -tools[t].friction * f.dot(n) + 1e-12 * f.norm());
  }
}

// Claim: the forces of several tools are those of phn_couple for the points that they hold, in one problem,
// and the deformation goes with it: every held point is where its tool is. Residuals of substitution: 1e-8.
TEST(SeveralTools, AreOneProblem) {
  Touch touch(bent_ball());
  const auto at = [](double height) {
    return std::vector<phn_contact_tool>{tool_at({height, 0.003, 0.002}, 0.004, PHN_TOOL_PRESS, 0.3),
                                         tool_at({0.002, height, 0.001}, 0.003),
                                         tool_at({0.012, 0.001, height}, 0, PHN_TOOL_PRESS, 1)};
  };
  std::vector<phn_contact_state> states;
  for (int i = 0; i <= 20; ++i) states = touch.step(at(0.06 - 0.0006 * i));
  const phn_tool held[3] = {states[0].held, states[1].held, states[2].held};
  Eigen::Matrix<double, 9, 1> forces;
  for (std::size_t t = 0; t < 3; ++t)
    EXPECT_LT((touch.moved(states[t].held) - vector(states[t].held.displacement)).norm(), 1e-8);
  ASSERT_GE(phn_couple(touch.loaded.model, touch.loaded.data, 3, held, forces.data(), nullptr), 0);
  for (std::size_t t = 0; t < 3; ++t) {
    EXPECT_EQ(states[t].in_contact, 1);
    EXPECT_LT((forces.segment<3>(3 * static_cast<Eigen::Index>(t)) - vector(states[t].force) / states[t].scale).norm(),
              states[t].unbalanced + 1e-12);
    EXPECT_LT(states[t].unbalanced, 1e-3 * vector(states[t].force).norm());
  }
}

// Claim: tools on one triangle, at one place, crossing each other, up to eight of them: every answer is
// defined, none pulls. Two at one place push together as one does, the deeper one alone.
TEST(SeveralTools, MayBeNearEachOther) {
  Touch touch(linear_ball(), 8);
  Numbers numbers;
  for (const std::size_t n : {2u, 3u, 8u}) {
    std::vector<phn_contact_tool> tools(n);
    phn_contact_reset(touch.contact);
    for (int i = 0; i < 150; ++i) {
      for (std::size_t t = 0; t < n; ++t) {
        const double spread = i % 3 == 0 ? 0 : i % 3 == 1 ? 1e-5 : 0.003;
        const double height = i < 2 ? 0.01 : 0.003 * numbers.next() - 0.001;
        tools[t] = tool_at({spread * numbers.next(), spread * numbers.next(), 0.054 + height}, 0.004,
                           t == 5 ? PHN_TOOL_GRASP : PHN_TOOL_PRESS, t % 2 == 0 ? 0.3 : 0);
      }
      expect_defined(touch.step(tools), tools);
    }
  }
  Touch two(linear_ball());
  const phn_contact_tool high = tool_at({0.001, 0, 0.06}, 0.004), low = tool_at({0.001, 0, 0.052}, 0.004),
                         lower = tool_at({0.001, 0, 0.051}, 0.004);
  two.step({high, high});
  const auto states = two.step({low, lower});
  Touch one(linear_ball());
  one.step(high);
  const auto alone = one.step(lower);
  EXPECT_EQ(states[0].in_contact, 0);
  EXPECT_LT((vector(states[1].force) - vector(alone.force)).norm(), 1e-9);
}

// Claim: a tool meets the surface where another has put it, pushed in late, pulled out early, exactly where the other's
// field says. 1e-5 m: a proxy that waits inside the surface at rest follows in a few steps a call.
TEST(SeveralTools, MeetTheSurfaceThatOthersMoved) {
  const LoadedModel& loaded = linear_ball();
  for (const bool pulled : {false, true}) {
    Touch touch(loaded);
    const Vector3d first(0, 0, pulled ? 0.06 : 0.046);
    const auto other = [&](double z) { return tool_at({0.012, 0, z}, 0.002); };
    const int mode = pulled ? PHN_TOOL_GRASP : PHN_TOOL_PRESS;
    std::vector<phn_contact_state> states;
    touch.step({tool_at({0, 0, 0.056}, 0.004, mode), other(0.08)});
    touch.step({tool_at({0, 0, 0.053}, 0.004, mode), other(0.08)});
    for (int i = 0; i < 3; ++i) states = touch.step({tool_at(first, 0.004, mode), other(0.08)});
    Points field(info_of(loaded.model).n_output, 3);
    ASSERT_GE(phn_contact_deform(touch.contact, field.data()), 0);
    double z = 0.065;
    const Vector3d alone = vector(states[0].force);
    while (z > 0.03 && !states[1].in_contact) {
      z -= 1e-6;
      states = touch.step({tool_at(first, 0.004, mode), other(z)});
    }
    ASSERT_EQ(states[1].in_contact, 1);
    // Continuous: both forces are still what they were.
    EXPECT_LT(vector(states[1].force).norm(), 250 * 2e-6);
    EXPECT_LT((vector(states[0].force) - alone).norm(), 250 * 2e-6);
    // The centre is on the displaced surface, moved out by the radius.
    const phn_tool& held = states[1].held;
    Vector3d u(0, 0, 0);
    for (int k = 0; k < 3; ++k) u += held.weights[k] * field.row(held.nodes[k]).transpose();
    EXPECT_GT(u.norm(), 0.001);
    EXPECT_LT((vector(states[1].proxy) + u - Vector3d(0.012, 0, z)).norm(), 1e-5) << pulled;
  }
}

// Claim: a surface that moves over a free tool catches it: what was pushed in comes back out against a tool
// that hovers in the dent.
TEST(SeveralTools, AreCaughtByASurfaceThatComesBack) {
  Touch touch(linear_ball());
  const auto pusher = [&](double z) { return tool_at({0, 0, z}, 0.004); };
  const auto hover = [&](double z) { return tool_at({0.008, 0, z}, 0.002); };
  const auto step = [&](double z, double y) { return touch.step({pusher(z), hover(y)}); };
  for (int i = 0; i <= 20; ++i) step(0.056 - 0.0007 * i, 0.06);
  for (int i = 0; i <= 20; ++i) EXPECT_EQ(step(0.042, 0.06 - 0.0006 * i)[1].in_contact, 0) << i;
  auto states = step(0.042, 0.048);
  for (int i = 0; i <= 30; ++i) states = step(0.042 + 0.001 * i, 0.048);
  EXPECT_EQ(states[0].in_contact, 0);
  EXPECT_EQ(states[1].in_contact, 1);
  EXPECT_LT(vector(states[1].force).dot(vector(states[1].normal)), -0.01);
}

/// From outside to 3.8 mm deep and back, twice a second, while the tool goes to and fro over the surface.
Vector3d pressed_at(const Vector3d& from, const Vector3d& to, double time, double phase) {
  const Vector3d at = (from + (1 - std::cos(2 * time)) / 2 * (to - from)).normalized();
  const double press = std::min(1.0, 10 * time) * std::pow(std::sin(std::acos(-1.0) * (time + phase)), 2);
  return (0.0542 - 0.004 * press) * at;
}

// Claim: two tools that press in turn near each other stay where they touch, also while the one has pushed the surface
// away from the other: what they displace is at most three times their depth below the undeformed surface, or that of
// the other, and one that is deepest by far is in contact. The body is a third as stiff at depth, so that responses to
// both are far from linear.
TEST(SeveralTools, StayWhereTheyTouch) {
  Numbers numbers;
  for (const double friction : {0.0, 0.2})
    for (int path = 0; path < 5; ++path) {
      Touch touch(bent_ball());
      std::array<Vector3d, 4> end;
      const Vector3d middle = random_direction(numbers);
      for (Vector3d& x : end) x = middle + 0.35 * random_direction(numbers);
      for (int k = 0; k < 1000; ++k) {
        const double time = k / 500.0;
        const std::vector<phn_contact_tool> tools = {
            tool_at(pressed_at(end[0], end[1], time, 0), 0.004, PHN_TOOL_PRESS, friction),
            tool_at(pressed_at(end[2], end[3], time, 0.3), 0.004, PHN_TOOL_PRESS, friction)};
        const auto states = touch.step(tools);
        double depth[2];
        for (std::size_t t = 0; t < 2; ++t) depth[t] = 0.054 - vector(tools[t].center).norm();
        for (std::size_t t = 0; t < 2; ++t) {
          ASSERT_LT(vector(states[t].held.displacement).norm(), 3 * std::max(std::max(depth[0], depth[1]), 0.0) + 5e-4)
              << friction << " " << path << " " << k << " " << t;
          if (depth[t] > 0.001 + depth[1 - t]) {
            ASSERT_EQ(states[t].in_contact, 1) << friction << " " << path << " " << k << " " << t;
          }
        }
      }
    }
}

}  // namespace
