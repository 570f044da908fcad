// Claim: each fault of positions, times or the body ends the loop at once for its reason, before the energy delivered
// to the hand exceeds the energy taken from it by 2 mJ. The force then is and remains zero.
#include <gtest/gtest.h>

#include <limits>

#include "rig.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double most_into_hand_J = 2e-3;
constexpr int before = 700;  ///< cycles without the fault: the hand is pressing
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Fault {
  const char* name;
  std::function<void(Rig&)> begin;
  int trip;
};

void freeze(Rig& rig) {
  while (rig.loop.report().speed_m_per_s < 0.03) rig.cycle();
  const Vector3 here = rig.device.position();
  rig.device.position_fault = [here](Vector3) { return here; };
}

TEST(Faults, Trip) {
  const Fault faults[] = {
      {"millimetres", [](Rig& rig) { rig.device.position_fault = [](Vector3 p) { return 1e3 * p; }; }, PHN_TRIP_JUMP},
      {"jump", [](Rig& rig) { rig.device.position_fault = [](Vector3 p) {
                                return p + Vector3{0.02, 0, 0};
                              }; },
       PHN_TRIP_JUMP},
      {"no positions", [](Rig& rig) { rig.device.stalled = 1'000; }, PHN_TRIP_STALE},
      {"frozen", freeze, PHN_TRIP_FROZEN},
      {"NaN", [](Rig& rig) { rig.device.position_fault = [](Vector3 p) {
                               return Vector3{nan, p.y, p.z};
                             }; },
       PHN_TRIP_NOT_FINITE},
      {"future", [](Rig& rig) { rig.time_error_s = 1.1e-3; }, PHN_TRIP_CLOCK},
      {"NaN of the body", [](Rig& rig) { rig.response_fault = [](phn_loop_response& r) { r.force[1] = nan; }; },
       PHN_TRIP_NOT_FINITE},
      {"refusal of the body",
       [](Rig& rig) { rig.response_fault = [](phn_loop_response& r) { r.status = PHN_ERROR_NOT_ACTIVE; }; },
       PHN_TRIP_BODY}};
  for (const Fault& fault : faults) {
    Body body(spring(150), 3);
    Rig rig(body, {}, 0.015);
    rig.run(before);
    ASSERT_EQ(rig.loop.report().state, PHN_LOOP_ON) << fault.name;
    fault.begin(rig);
    ASSERT_GE(rig.run_until_trip(3'000), 0) << fault.name;
    EXPECT_EQ(rig.loop.report().trip, fault.trip) << fault.name << ": " << rig.loop.why();
    const double so_far = rig.largest;
    rig.largest = 0;
    rig.run(200);
    EXPECT_EQ(rig.largest, 0) << fault.name;
    EXPECT_GT(so_far, 0.1) << fault.name;
    EXPECT_LT(rig.device.energy().most_to_hand, most_into_hand_J) << fault.name;
    EXPECT_NE(phn_loop_engage(rig.loop), PHN_OK);  // it stays off until it is made anew
  }
}

// Claim: a loop that delivers energy trips, here a coupling that is too stiff for the latency, without the controller.
TEST(Faults, OfPassivityTrip) {
  Body body(spring(3000), 3);
  DeviceSettings device;
  device.latency_samples = 2;
  device.friction_Ns_per_m = 0.05;
  Rig rig(body, device, 0.01, [](phn_loop_settings& s) {
    s.coupling_N_per_m = 2000;
    s.allowance_J = 1e3;  // no controller
    s.trip_force_N = s.trip_speed_m_per_s = 0;
  });
  ASSERT_GE(rig.run_until_trip(10'000), 0);
  EXPECT_EQ(rig.loop.report().trip, PHN_TRIP_ENERGY) << rig.loop.why();
  EXPECT_LT(rig.device.energy().most_to_hand, most_into_hand_J);
}

// Claim: a body that pushes along instead of back delivers nothing.
TEST(Faults, OfTheBodyAreHeldBack) {
  Body body(spring(150), 3);
  Rig rig(body, {}, 0.015);
  rig.run(before);
  rig.response_fault = [](phn_loop_response& r) {
    for (double& f : r.force) f = -f;
    r.has_stiffness = 0;
  };
  rig.run(5'000);
  EXPECT_LT(rig.device.energy().most_delivered, 1e-4);
  EXPECT_GT(rig.loop.report().limited, 1'000);
}

// Claim: a hand that holds a device still does not look like frozen positions: the force stays.
TEST(Faults, AreNotSeenInAHandAtRest) {
  Body body(spring(460), 3);
  for (const double resolution : {1e-5, 5e-5}) {
    DeviceSettings device;
    device.resolution_m = resolution;
    device.mass_kg = 0.3;
    Rig rig(body, device, [](double t) { return Vector3{0, 0, -0.015 * std::min(1.0, t)}; });
    EXPECT_EQ(rig.run_until_trip(20'000), -1) << rig.loop.why();
    double least = 10;
    for (int i = 0; i < 2'000; ++i) least = std::min(least, std::fabs(rig.cycle().z));
    EXPECT_GT(least, 0.8 * rig.largest) << resolution;
  }
}

// Claim: the limits of speed and force trip.
TEST(Faults, OfLimitsTrip) {
  Body body(spring(150), 3);
  Rig fast(body, {}, 0.02, [](phn_loop_settings& s) { s.trip_speed_m_per_s = 0.01; });
  EXPECT_GE(fast.run_until_trip(2'000), 0);
  EXPECT_EQ(fast.loop.report().trip, PHN_TRIP_SPEED);
  Rig strong(body, {}, 0.02, [](phn_loop_settings& s) { s.trip_force_N = 0.2; });
  EXPECT_GE(strong.run_until_trip(2'000), 0);
  EXPECT_EQ(strong.loop.report().trip, PHN_TRIP_FORCE);
}

// Claim: a late cycle, and a clock that stands still or runs backwards, end the force at once.
TEST(Faults, OfTimeTrip) {
  Body body(spring(150), 3);
  for (const double step : {0.05, 0.0, -0.01}) {
    Rig rig(body, {}, 0.01);
    rig.run(before);
    ASSERT_GT(rig.largest, 0);
    const double now = rig.device.now() - 1e-3 + step;
    const Vector3 at = rig.device.position();
    const double here[3] = {at.x, at.y, at.z};
    double tool[3], force[3] = {1, 1, 1};
    const phn_loop_response none = {};
    EXPECT_EQ(phn_loop_read(rig.loop, here, now, now, tool), step < 0 ? PHN_ERROR_CLOCK : PHN_OK);
    phn_loop_hold(rig.loop, &none, now, force);
    EXPECT_EQ(rig.loop.report().trip, step > 0 ? PHN_TRIP_OVERRUN : PHN_TRIP_CLOCK);
    for (const double f : force) EXPECT_EQ(f, 0);
  }
}

// Claim: minutes at a normal coupling do not trip.
TEST(Faults, NothingElseTrips) {
  Body body(small_model_of(Family::modal), 3);
  Rig rig(body, {}, 0.01);
  EXPECT_EQ(rig.run_until_trip(200'000), -1) << rig.loop.why();
}

}  // namespace
