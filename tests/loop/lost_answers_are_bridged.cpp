// Claims about phn_bridge_force: an answer is rendered as it is; without one its force is held for 10 ms and is zero
// after 100 ms more, by equal parts in each cycle; when answers come again it rises in the same way. No time makes it
// jump.
#include <gtest/gtest.h>
#include <phynness/phynness.h>
#include <phynness/phynness_loop.h>

#include <cmath>

namespace {

constexpr double cycle = 1e-3;

struct Host {
  phn_bridge bridge{};
  double now = 5, force[3] = {};
  int step(const double* answer, double passed = cycle) {
    now += passed;
    return phn_bridge_force(&bridge, answer, now, force);
  }
};

TEST(Bridge, HoldsThenLowersThenRises) {
  Host host;
  const double answer[3] = {3, -4, 12};
  EXPECT_EQ(host.step(nullptr), PHN_OK);
  EXPECT_EQ(host.force[2], 0) << "no answer has come yet";
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(host.step(answer), PHN_OK);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(host.force[k], answer[k]);
  }
  double last = 1, largest_change = 0;
  for (int i = 1; i <= 130; ++i) {
    EXPECT_EQ(host.step(nullptr), PHN_OK);
    const double part = host.force[2] / answer[2], expected = std::fmin(1, std::fmax(0, 1 - (i * cycle - 0.01) / 0.1));
    EXPECT_NEAR(part, expected, 1e-12) << i;
    EXPECT_EQ(host.force[0] * answer[2], host.force[2] * answer[0]);
    largest_change = std::fmax(largest_change, std::fabs(part - last));
    last = part;
  }
  EXPECT_EQ(last, 0);
  EXPECT_NEAR(largest_change, 0.01, 1e-12);
  for (int i = 1; i <= 120; ++i) {
    EXPECT_EQ(host.step(answer), PHN_OK);
    EXPECT_NEAR(host.force[1] / answer[1], std::fmin(1, 0.01 * i), 1e-12) << i;
  }
}

// Cycles of any length lead to the same force.
TEST(Bridge, DoesNotDependOnTheCycle) {
  const double answer[3] = {1, 0, 0};
  for (const double at : {0.005, 0.03, 0.09, 0.2}) {
    Host one, many;
    one.step(answer);
    many.step(answer);
    one.step(nullptr, at);
    for (int i = 0; i < 7; ++i) many.step(nullptr, at / 7);
    EXPECT_NEAR(one.force[0], many.force[0], 1e-12) << at;
  }
}

TEST(Bridge, IsDefinedForEveryInput) {
  Host host;
  const double answer[3] = {1, 2, 3}, bad[3] = {0, NAN, 0};
  double force[3];
  host.step(answer);
  EXPECT_EQ(host.step(bad), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(host.force[2], 3);
  EXPECT_EQ(host.step(answer, 0), PHN_ERROR_CLOCK);
  EXPECT_EQ(host.force[2], 3);
  EXPECT_EQ(phn_bridge_force(&host.bridge, answer, NAN, force), PHN_ERROR_CLOCK);
  EXPECT_EQ(force[2], 3);
  EXPECT_EQ(host.step(nullptr, 1e300), PHN_OK);
  EXPECT_EQ(host.force[2], 0);
  EXPECT_EQ(phn_bridge_force(nullptr, answer, 1, force), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_bridge_force(&host.bridge, answer, 1, nullptr), PHN_ERROR_ARGUMENT);
}

}  // namespace
