// Claim: each fault ends the loop for its reason before the energy delivered to the hand exceeds the energy taken from
// it by 2 mJ. The force then decreases to zero within the ramp and remains zero. Faults of forces have an effect only
// while the motors have a force.
#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

#include "rig.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double most_into_hand_J = 2e-3;
constexpr int before = 700;  ///< cycles without the fault: the hand is pressing

bool on(Vector3 f) { return f.x != 0 || f.y != 0 || f.z != 0; }

void freeze(Rig& rig) {
  const Vector3 here = rig.device.position();
  rig.device.position_fault = [here](Vector3) { return here; };
}

struct Fault {
  const char* name;
  std::function<void(Rig&)> begin;
  int trip;
};

void expect_tripped(Rig& rig, const Fault& fault) {
  rig.run(before);
  ASSERT_EQ(rig.loop.report().state, PHN_LOOP_ON) << fault.name;
  fault.begin(rig);
  ASSERT_GE(rig.run_until_trip(3'000), 0) << fault.name;
  EXPECT_EQ(rig.loop.report().trip, fault.trip) << fault.name << ": " << phn_loop_trip_message(rig.loop.report().trip);
  EXPECT_LT(rig.device.energy().most_to_hand, most_into_hand_J) << fault.name;
  const double at_trip = rig.device.energy().delivered, hand_at_trip = rig.device.energy().to_hand;
  rig.run(static_cast<int>(1e3 * rig.settings.trip_ramp_s) + 1);
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(on(rig.cycle())) << fault.name;
  std::printf("%-22s trip %d, delivered to the device %.2f mJ, to the hand %.2f mJ; 0.2 s later %.2f and %.2f mJ\n",
              fault.name, rig.loop.report().trip, 1e3 * at_trip, 1e3 * hand_at_trip,
              1e3 * rig.device.energy().delivered, 1e3 * rig.device.energy().to_hand);
  EXPECT_LT(rig.device.energy().most_to_hand, 2 * most_into_hand_J) << fault.name;  // with the speed of the device
  EXPECT_NE(rig.loop.engage(), PHN_OK);                                             // it stays off until a reset
}

TEST(Faults, OfForcesTrip) {
  const Fault faults[] = {
      {"negative damping",
       [](Rig& rig) {
         rig.device.force_fault = [](Vector3 f, Vector3, Vector3 v) {
           return on(f) ? Vector3{f.x + 30 * v.x, f.y + 30 * v.y, f.z + 30 * v.z} : f;
         };
       },
       PHN_TRIP_ENERGY},
      {"curl",
       [](Rig& rig) {
         rig.device.force_fault = [](Vector3 f, Vector3 x, Vector3) {
           return on(f) ? Vector3{f.x - 300 * x.y, f.y + 300 * x.x, f.z} : f;
         };
       },
       PHN_TRIP_ENERGY},
      {"sign",
       [](Rig& rig) { rig.device.force_fault = [](Vector3 f, Vector3, Vector3) {
                        return Vector3{-f.x, -f.y, -f.z};
                      }; },
       PHN_TRIP_ENERGY}};
  for (const Fault& fault : faults) {
    Body body(spring(150), 3);
    Rig rig(body, {}, 0.015);
    expect_tripped(rig, fault);
  }
}

// Claim: forces on wrong axes trip, or nothing of them gets through; a body that pushes along instead of back delivers
// nothing.
TEST(Faults, AreHeldBack) {
  {
    Body body(spring(150), 3);
    Rig rig(body, {}, 0.015);
    rig.run(before);
    rig.device.force_fault = [](Vector3 f, Vector3, Vector3) { return Vector3{f.z, f.x, f.y}; };
    rig.run(5'000);
    EXPECT_LT(rig.device.energy().most_delivered, most_into_hand_J);
  }
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

TEST(Faults, OfPositionsTrip) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Fault faults[] = {
      {"millimetres",
       [](Rig& rig) { rig.device.position_fault = [](Vector3 p) {
                        return Vector3{1e3 * p.x, 1e3 * p.y, 1e3 * p.z};
                      }; },
       PHN_TRIP_JUMP},
      {"jump", [](Rig& rig) { rig.device.position_fault = [](Vector3 p) {
                                return Vector3{p.x + 0.02, p.y, p.z};
                              }; },
       PHN_TRIP_JUMP},
      {"no positions", [](Rig& rig) { rig.device.stall(1'000); }, PHN_TRIP_STALE},
      {"frozen",
       [](Rig& rig) {
         while (rig.loop.report().speed_m_per_s < 0.03) rig.cycle();
         freeze(rig);
       },
       PHN_TRIP_FROZEN},
      {"NaN", [nan](Rig& rig) { rig.device.position_fault = [nan](Vector3 p) {
                                  return Vector3{nan, p.y, p.z};
                                }; },
       PHN_TRIP_NOT_FINITE},
      {"NaN of the body", [nan](Rig& rig) { rig.response_fault = [nan](phn_loop_response& r) { r.force[1] = nan; }; },
       PHN_TRIP_NOT_FINITE},
      {"refusal of the body",
       [](Rig& rig) { rig.response_fault = [](phn_loop_response& r) { r.status = PHN_ERROR_NOT_ACTIVE; }; },
       PHN_TRIP_BODY}};
  for (const Fault& fault : faults) {
    Body body(spring(150), 3);
    Rig rig(body, {}, 0.015);
    expect_tripped(rig, fault);
  }
}

// Claim: whenever the positions freeze, the force is zero after 0.15 s, and less than 2 mJ more have gone into the hand
// than it gave. Where the force was above 1 N, the loop trips.
TEST(Faults, OfPositionsThatFreezeEndTheForce) {
  double most = 0;
  int tripped = 0, frozen = 0;
  for (const double stiffness : {9.0, 150.0, 460.0}) {
    Body body(spring(stiffness), 3);
    for (int start = 700; start < 3'200; start += 49) {
      Rig rig(body, {}, 0.02, [](phn_loop_settings& s) { s.reach_m = 0; });
      rig.run(start);
      freeze(rig);
      rig.run(150 + 10);  // and the time of the last samples that were right
      const Vector3 force = rig.cycle();
      const double size = std::hypot(force.x, force.y, force.z);
      EXPECT_LE(size, 0.1) << stiffness << ' ' << start;  // what is not felt
      EXPECT_LT(rig.device.energy().most_to_hand, most_into_hand_J) << stiffness << ' ' << start;
      most = std::max(most, rig.device.energy().most_to_hand);
      tripped += rig.loop.report().trip == PHN_TRIP_FROZEN;
      EXPECT_TRUE(rig.loop.report().trip == PHN_TRIP_FROZEN || rig.loop.report().trip == PHN_TRIP_NONE);
      ++frozen;
    }
  }
  EXPECT_GT(tripped, frozen / 2);
  std::printf("frozen at %d moments: %d trips, at most %.2f mJ to the hand\n", frozen, tripped, 1e3 * most);
}

// Claim: a hand that holds a device still against a force does not look like that: the force stays, although positions
// change by single steps only.
TEST(Faults, OfPositionsAreNotSeenInAHandAtRest) {
  Body body(spring(460), 3);
  for (const double resolution : {1e-5, 5e-5}) {
    SimulatedDeviceSettings device;
    device.resolution_m = resolution;
    device.mass_kg = 0.3;
    Rig rig(body, device, [](double t) { return Vector3{0, 0, -0.015 * std::min(1.0, t)}; });
    EXPECT_EQ(rig.run_until_trip(20'000), -1) << phn_loop_trip_message(rig.loop.report().trip);
    double least = 10;
    for (int i = 0; i < 2'000; ++i) least = std::min(least, std::fabs(rig.cycle().z));
    EXPECT_GT(least, 0.8 * rig.largest) << resolution;
  }
}

// Claim: axes, signs and units that are wrong from the beginning are found by the test pulses, before the body can be
// felt; right ones pass, with latency, losses and a moving hand too.
TEST(Faults, OfFramesAreFoundByTheTestPulses) {
  const std::function<Vector3(Vector3)> wrong[] = {[](Vector3 p) {
                                                     return Vector3{-p.x, p.y, p.z};
                                                   },
                                                   [](Vector3 p) {
                                                     return Vector3{-p.x, -p.y, -p.z};
                                                   },
                                                   [](Vector3 p) {
                                                     return Vector3{p.y, p.x, p.z};
                                                   },
                                                   [](Vector3 p) {
                                                     return Vector3{p.y, p.z, p.x};
                                                   },
                                                   [](Vector3) { return Vector3{}; },
                                                   [](Vector3 p) {
                                                     return Vector3{1e3 * p.x, 1e3 * p.y, 1e3 * p.z};
                                                   }};
  Body body(spring(150), 3);
  const auto checked = [](phn_loop_settings& s) {
    s.check_force_N = 0.4;
    s.trip_jump_m = s.trip_speed_m_per_s = 0;  // the pulses alone are to find them
  };
  for (const auto& fault : wrong) {
    Rig rig(body, {}, 0.005, checked);
    rig.device.position_fault = fault;
    EXPECT_GE(rig.run_until_trip(4'000), 0);
    EXPECT_EQ(rig.loop.report().trip, PHN_TRIP_CHECK);
    EXPECT_LE(rig.largest, 0.4 * (1 + 1e-12));
  }
  for (const int latency : {0, 2, 5}) {
    for (const double reach : {0.0, 0.01}) {
      for (const double friction : {0.05, 2.0}) {
        SimulatedDeviceSettings device;
        device.latency_samples = latency;
        device.friction_Ns_per_m = friction;
        device.lost = 0.02;
        Rig rig(body, device, reach, checked);
        rig.run(3'000);
        EXPECT_EQ(rig.loop.report().state, PHN_LOOP_ON) << latency << ' ' << reach << ' ' << friction;
      }
    }
  }
}

// Claim: motors that apply another force than commanded, and say so, trip during the test pulses, before 2 mJ reach the
// hand. A device that nobody holds passes the pulses and stays on.
TEST(Faults, OfMotorsFromTheBeginningTripDuringTheTestPulses) {
  const auto checked = [](phn_loop_settings& s) { s.check_force_N = 0.4; };
  const std::function<Vector3(Vector3, Vector3, Vector3)> wrong[] = {
      [](Vector3 f, Vector3, Vector3 v) {
        return on(f) ? Vector3{f.x + 30 * v.x, f.y + 30 * v.y, f.z + 30 * v.z} : f;
      },
      [](Vector3 f, Vector3, Vector3) {
        return on(f) ? Vector3{8, 0, 0} : f;
      },
      [](Vector3 f, Vector3, Vector3 v) {
        return on(f) ? Vector3{f.x + 5 * v.x, f.y + 5 * v.y, f.z + 5 * v.z} : f;
      }};
  for (const auto& fault : wrong) {
    const bool is_weak = &fault == &wrong[2];
    SimulatedDeviceSettings device;
    if (is_weak) device.hand_damping_Ns_per_m = 1;
    Body body(spring(150), 3);
    Rig rig(body, device, 0.015, checked);
    rig.device.force_fault = fault;
    ASSERT_GE(rig.run_until_trip(1'000), 0);
    // The weak one may be found by what it says or by its energy.
    const int trip = rig.loop.report().trip;
    EXPECT_TRUE(trip == PHN_TRIP_CHECK || (is_weak && trip == PHN_TRIP_ENERGY)) << phn_loop_trip_message(trip);
    rig.run(200);
    EXPECT_LT(rig.device.energy().most_to_hand, most_into_hand_J);
    std::printf("motors, fault %d: %.2f mJ to the hand\n", static_cast<int>(&fault - wrong),
                1e3 * rig.device.energy().most_to_hand);
  }
  SimulatedDeviceSettings alone;
  alone.hand_stiffness_N_per_m = alone.hand_damping_Ns_per_m = 0;
  Body body(spring(150), 3);
  Rig rig(body, alone, 0, checked);
  EXPECT_EQ(rig.run_until_trip(5'000), -1) << phn_loop_trip_message(rig.loop.report().trip);
  EXPECT_EQ(rig.loop.report().state, PHN_LOOP_ON);
}

// Claim: the test pulses pass devices of 5 g to 1 kg in a loose and in a firm hand, or in none, at periods of 0.1 to 4
// ms. haptic-loop.md has the table.
TEST(Faults, OfNoneAreFoundInRightDevices) {
  struct Hand {
    double stiffness, damping;
  };
  Body body(spring(0), 3);
  for (const double period : {1e-4, 1e-3, 2e-3, 4e-3})
    for (const double mass : {0.005, 0.02, 0.08, 0.5, 1.0})
      for (const Hand hand : {Hand{0, 0}, Hand{100, 1}, Hand{250, 4}, Hand{500, 10}}) {
        SimulatedDeviceSettings device;
        device.period_s = period;
        device.mass_kg = mass;
        device.hand_stiffness_N_per_m = hand.stiffness;
        device.hand_damping_Ns_per_m = hand.damping;
        Rig rig(body, device, hand.stiffness > 0 ? 0.01 : 0, [](phn_loop_settings& s) { s.check_force_N = 0.4; });
        while (rig.loop.report().state == PHN_LOOP_CHECKING) rig.cycle();
        EXPECT_NE(rig.loop.report().state, PHN_LOOP_TRIPPED)
            << period << ' ' << mass << ' ' << hand.stiffness << phn_loop_trip_message(rig.loop.report().trip);
      }
}

// Claim: a clock that is set back or stands still, a position that is younger than it can be (a clock of the device
// that is a tenth of a period ahead) and a force that no device has end the force at once; no force is ever NaN.
TEST(Faults, OfClocksEndTheForceAtOnce) {
  enum Kind { set_back, stands, future, report };
  for (const Kind kind : {set_back, stands, future, report}) {
    Body body(spring(150), 3);
    Rig rig(body, {}, 0.015);
    rig.run(before);
    ASSERT_EQ(rig.loop.report().state, PHN_LOOP_ON);
    const double begin = rig.device.now();
    double force[3] = {1, 1, 1}, tool[3];
    int cycles = 0;
    for (; cycles < 200 && rig.loop.report().state != PHN_LOOP_TRIPPED; ++cycles) {
      const double now = kind == set_back ? begin - 3 + 1e-3 * cycles : kind == stands ? begin : begin + 1e-3 * cycles;
      const Vector3 at = rig.device.position();
      // The least age of a position is a millisecond.
      const phn_loop_sample sample = {{at.x, at.y, at.z}, kind == future ? now - 0.0009 : now - 0.001};
      rig.loop.read(&sample, now, tool).ignore();
      rig.loop.hold(body.at(tool), now, force).ignore();
      for (const double f : force) EXPECT_TRUE(std::isfinite(f));
      const double huge[] = {1e308, -1e308, 0};
      if (kind == report) rig.loop.held(huge).ignore();
    }
    EXPECT_EQ(rig.loop.report().trip, kind == report ? PHN_TRIP_NOT_FINITE : PHN_TRIP_CLOCK) << kind;
    EXPECT_LE(cycles, kind == stands ? 60 : 1) << kind;
    if (kind != report) {
      EXPECT_FALSE(on({force[0], force[1], force[2]})) << kind;
    }
  }
}

// Claim: the limits of speed and force and a late cycle trip; a clock that runs backwards does.
TEST(Faults, OfLimitsAndTimeTrip) {
  Body body(spring(150), 3);
  Rig fast(body, {}, 0.02, [](phn_loop_settings& s) { s.trip_speed_m_per_s = 0.01; });
  EXPECT_GE(fast.run_until_trip(2'000), 0);
  EXPECT_EQ(fast.loop.report().trip, PHN_TRIP_SPEED);
  Rig strong(body, {}, 0.02, [](phn_loop_settings& s) { s.trip_force_N = 0.2; });
  EXPECT_GE(strong.run_until_trip(2'000), 0);
  EXPECT_EQ(strong.loop.report().trip, PHN_TRIP_FORCE);
  for (const double step : {0.05, -0.01}) {
    Rig rig(body, {}, 0.01);
    rig.run(500);
    const phn_loop_sample sample = {{0, 0, 0}, rig.device.now() + std::max(step, 0.0) - rig.settings.latency_s};
    double tool[3], force[3];
    const phn_loop_response none = {};
    const int status = rig.loop.read(&sample, rig.device.now() + step, tool);
    EXPECT_EQ(status, step > 0 ? PHN_OK : PHN_ERROR_CLOCK);
    rig.loop.hold(none, rig.device.now() + std::max(step, 0.0), force).ignore();
    EXPECT_EQ(rig.loop.report().trip, step > 0 ? PHN_TRIP_OVERRUN : PHN_TRIP_CLOCK);
  }
}

// Claim: an hour at a normal coupling does not trip. The 10^7 cycles are lab/study passivity's.
TEST(Faults, NothingElseTrips) {
  Body body(small_model_of(Family::modal), 3);
  Rig rig(body, {}, 0.01, [](phn_loop_settings& s) { s.check_force_N = 0.4; });
  EXPECT_EQ(rig.run_until_trip(200'000), -1) << phn_loop_trip_message(rig.loop.report().trip);
}

}  // namespace
