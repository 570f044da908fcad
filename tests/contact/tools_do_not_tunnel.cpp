#include "touched_body.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double thickness = 0.002;

const LoadedModel& thin_plate() {
  static const LoadedModel loaded(write_model_text(linear_model(plate(thickness))));
  return loaded;
}

bool inside(const Vector3d& x) {
  return std::abs(x[0]) < 0.05 && std::abs(x[1]) < 0.05 && std::abs(x[2]) < thickness / 2;
}

class AnySpeed : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(MetresPerTick, AnySpeed, testing::Values(1e-4, 1e-3, 1e-2, 1e-1, 1.0),
                         [](const auto& info) { return "um" + std::to_string(std::lround(1e6 * info.param)); });

// Claim: a tool that flies through a plate of 2 mm, in any direction and at any speed up to a metre in a tick, is
// caught on the side it came from and pushed back there for as long as it is behind. Seldom through the rim. It sticks,
// so that it cannot slip round the plate; directions are within 60 degrees of the normal, where sticking does not pull.
TEST_P(AnySpeed, FlightsEndAtThePlate) {
  Touch touch(thin_plate());
  Numbers numbers;
  const double step = GetParam();
  for (int flight = 0; flight < (step < 5e-4 ? 30 : 300); ++flight) {
    phn_contact_reset(touch.contact);
    Vector3d along = random_direction(numbers);
    while (std::abs(along[2]) < 0.5) along = random_direction(numbers);
    const double radius = flight % 3 == 0 ? 0 : 0.004 * (flight % 3);
    const Vector3d through(0.04 * numbers.next(), 0.04 * numbers.next(), 0);
    const double before = 0.03 + 0.5 * step * (1 + numbers.next());
    for (double s = -before; s < 0.02 + 2 * step; s += step) {
      const Vector3d c = through + s * along;
      const auto state = touch.step(tool_at(c, radius, PHN_TOOL_PRESS, 1e3));
      const bool behind = c[2] * along[2] > 0;
      const bool clear = -c[2] * along[2] > (thickness + 2.1 * radius) * std::abs(along[2]);
      if (behind) {
        ASSERT_EQ(state.in_contact, 1) << flight << " at " << s;
        ASSERT_LT(vector(state.force).dot(vector(state.normal)), 0);
        ASSERT_LT(vector(state.normal)[2] * along[2], 0);
        ASSERT_LT((vector(state.proxy))[2] * along[2], 0);
      }
      if (clear) {
        ASSERT_EQ(state.in_contact, 0);
      }
    }
  }
}

// Claim: a frictionless tool on a random walk, in and out, over faces and rims, is felt whenever its centre
// is inside the plate, and its proxy never is. Beyond 10 m/s it may jump round half of the plate in a tick,
// which takes the proxy up to ten ticks to follow.
TEST_P(AnySpeed, InsideIsAlwaysFelt) {
  Touch touch(thin_plate());
  Numbers numbers;
  int n_inside = 0, n_free = 0;
  Vector3d c(0, 0, 0.03);
  for (int i = 0; i < 20000; ++i) {
    // Drawn to a target that moves around, in steps of at most the speed.
    const Vector3d target(0.07 * numbers.next(), 0.07 * numbers.next(), 0.01 * numbers.next());
    const Vector3d way = target - c;
    const double length = std::abs(numbers.next()) * GetParam();
    c += length < way.norm() ? length * way.normalized() : way;
    const double radius = 0.003;
    auto state = touch.step(tool_at(c, radius));
    for (int k = 0; GetParam() > 0.01 && k < 10 && inside(c) && !state.in_contact; ++k)
      state = touch.step(tool_at(c, radius));
    n_inside += inside(c);
    n_free += !state.in_contact;
    if (inside(c)) {
      ASSERT_EQ(state.in_contact, 1) << i;
    }
    ASSERT_FALSE(inside(vector(state.proxy))) << i;
  }
  EXPECT_GT(n_inside, 200);
  EXPECT_GT(n_free, 200);
}

// Claim: a tool switched on inside the body is not thrown out: it leaves unfelt, and is felt when it comes
// again. So is one whose radius grows over the surface beside it.
TEST(Tunnelling, WhereAToolBeginsIsItsOwnAffair) {
  Touch touch(linear_ball());
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.03}, 0.002)).in_contact, 0);
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.06}, 0.002)).in_contact, 0);
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.05}, 0.002)).in_contact, 1);
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.05}, 0.002, PHN_TOOL_OFF)).in_contact, 0);
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.0529}, 0.002)).in_contact, 0);
  EXPECT_EQ(touch.step(tool_at({0, 0, 0.0529}, 0.004)).in_contact, 1);
}

}  // namespace
