#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

struct Case {
  bool bent;
  double friction;
};
void PrintTo(const Case& c, std::ostream* out) { *out << (c.bent ? "bent, " : "linear, ") << c.friction; }

class Pressing : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Bodies, Pressing,
                         testing::Values(Case{false, 0}, Case{true, 0}, Case{true, 0.1}, Case{false, 0.5},
                                         Case{true, 2}),
                         [](const auto& info) {
                           const long tenths = std::lround(10 * info.param.friction);
                           return (info.param.bent ? "bent" : "linear") + std::to_string(tenths);
                         });

// Claim: wherever a tool wanders over a ball, a millimetre a tick and up to 5 mm deep, it is never pulled,
// its tangential force is within the cone and without friction 0, both to rounding. What sliding leaves
// outside the cone in its fixed number of steps is 1e-4 of the force but for one tick in a hundred, and the
// force is phn_couple's but for that and for the scale.
TEST_P(Pressing, NeverPullsAndStaysInTheCone) {
  const LoadedModel& loaded = GetParam().bent ? bent_ball() : linear_ball();
  Touch touch(loaded);
  Numbers numbers;
  const double mu = GetParam().friction, radius = 0.004;
  int n_touching = 0, n_unbalanced = 0, n_on_cone = 0;
  Vector3d at = random_direction(numbers);
  double height = 0.01;
  for (int i = 0; i < 4000; ++i) {
    at = (at + 0.02 * random_direction(numbers)).normalized();
    height = std::clamp(height + 0.0005 * numbers.next() - (i % 500 < 250 ? 2e-4 : -2e-4), -0.005, 0.01);
    const Vector3d c = (0.05 + radius + height) * at;
    const auto state = touch.step(tool_at(c, radius, PHN_TOOL_PRESS, mu));
    const Vector3d f = vector(state.force), n = vector(state.normal);
    if (!state.in_contact) {
      EXPECT_EQ(f.norm(), 0);
      EXPECT_EQ(state.held.nodes[0], -1);
      continue;
    }
    ++n_touching;
    const double push = -f.dot(n), sideways = (f + push * n).norm();
    ASSERT_GT(push, 0);
    ASSERT_LE(sideways, mu * push + 1e-12 * f.norm()) << i;
    ASSERT_TRUE(state.scale > 0 && state.scale <= 1);
    ASSERT_NEAR(n.norm(), 1, 1e-12);
    n_on_cone += sideways > 0.99 * mu * push;
    n_unbalanced += state.unbalanced > 2e-4 * f.norm();
    Vector3d said;
    EXPECT_GE(phn_couple(loaded.model, loaded.data, 1, &state.held, said.data(), nullptr), 0);
    EXPECT_NEAR((said - f / state.scale).norm(), state.unbalanced, 1e-12);
  }
  EXPECT_GT(n_touching, 1000);
  EXPECT_GT(n_on_cone, mu < 1 ? 500 : 20);
  EXPECT_LE(n_unbalanced, n_touching / 100);
}

// Claim: inside the cone the point sticks, to the bit; pushed beyond it goes on sticking where it came to.
TEST(Pressing, SticksInsideTheCone) {
  Touch touch(bent_ball());
  const auto pressed = [&](double x) { return touch.step(tool_at({x, 0.001, 0.051}, 0.004, PHN_TOOL_PRESS, 0.5)); };
  touch.step(tool_at({0, 0.001, 0.06}, 0.004, PHN_TOOL_PRESS, 0.5));
  const auto first = pressed(0), near = pressed(0.0003), far = pressed(0.004), back = pressed(0.0038);
  const auto same = [](const phn_tool& a, const phn_tool& b) {
    return std::equal(a.nodes, a.nodes + 3, b.nodes) && std::equal(a.weights, a.weights + 3, b.weights);
  };
  EXPECT_TRUE(same(first.held, near.held));
  EXPECT_FALSE(same(near.held, far.held));
  EXPECT_TRUE(same(far.held, back.held));
}

}  // namespace
