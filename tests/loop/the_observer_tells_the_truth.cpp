// Claim: the work that the observer tells is the true work of the forces that the device held, up to 2 % of the energy
// that was exchanged or 20 uJ, whatever the latency, jitter, losses, coupling, damping, motion and family. 2 % is the
// error at which an energy of the size of the trip (1 mJ) is told within the allowance (20 uJ).
#include <gtest/gtest.h>

#include "rig.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

struct Point {
  const char* name;
  double jitter_s, late_s, lost, twice;
};

TEST(Observer, TellsTheTrueWork) {
  const Point points[] = {{"regular", 0, 0, 0, 0},
                          {"jitter", 4e-4, 0, 0, 0},
                          {"late and reordered", 0, 3e-3, 0, 0},
                          {"lost", 0, 0, 0.05, 0},
                          {"all", 3e-4, 2e-3, 0.1, 0.1}};
  int compared = 0, reordered = 0, repeated = 0, missing = 0;
  for (const Family family : {Family::linear, Family::modal, Family::rbfn}) {
    Body body(family == Family::linear ? spring(150) : small_model_of(family), 3);
    for (const Point& point : points) {
      for (int latency = 0; latency <= 5; ++latency) {
        for (const double coupling : {100.0, 400.0, 2000.0}) {
          for (const double friction : {0.05, 2.0}) {
            SimulatedDeviceSettings device;
            device.latency_samples = latency;
            device.friction_Ns_per_m = friction;
            device.jitter_s = point.jitter_s;
            device.late_s = point.late_s;
            device.lost = point.lost;
            device.twice = point.twice;
            // The observer alone, and every second time with the controller.
            const bool controlled = (latency + compared) % 2 == 0;
            Rig rig(body, device, coupling > 1000 ? 0.01 : 0.03, [&](phn_loop_settings& s) {
              s.coupling_N_per_m = coupling;
              s.passivity_controller = controlled ? 1 : 0;
              s.trip_energy_J = s.trip_force_N = 0;
            });
            rig.run(2'000);
            const double gross = rig.device.energy().gross;
            ASSERT_GT(gross, 1e-4);
            EXPECT_LT(rig.largest_difference, std::max(0.02 * gross, 2e-5))
                << name(family) << ' ' << point.name << " latency " << latency << " coupling " << coupling
                << " friction " << friction << " gross " << gross;
            const phn_loop_report report = rig.loop.report();
            reordered += static_cast<int>(report.reordered);
            repeated += static_cast<int>(report.repeated);
            missing += static_cast<int>(report.missing);
            ++compared;
          }
        }
      }
    }
  }
  EXPECT_EQ(compared, 3 * 5 * 6 * 3 * 2);
  EXPECT_GT(reordered, 100);
  EXPECT_GT(repeated, 100);
  EXPECT_GT(missing, 1000);
}

// Claim: without times in the samples the declared latency does the same; a wrong one is off.
TEST(Observer, TakesTheDeclaredLatency) {
  Body body(spring(300), 3);
  double differences[2];
  for (const int declared : {3, 0}) {
    SimulatedDeviceSettings device;
    device.latency_samples = 3;
    device.has_times = false;
    Rig rig(body, device, 0.03, [&](phn_loop_settings& s) {
      s.latency_s = declared * 1e-3;
      s.passivity_controller = 0;
      s.trip_energy_J = 0;
      s.coupling_N_per_m = 1500;
    });
    rig.run(20'000);
    const phn_loop_report report = rig.loop.report();
    differences[declared == 0] = std::fabs(report.work_J + rig.device.energy().delivered) / rig.device.energy().gross;
  }
  EXPECT_LT(differences[0], 0.02);
  EXPECT_GT(differences[1], 5 * differences[0]);
}

// Claim: what the device says that it held counts, not what it was told to hold.
TEST(Observer, CountsTheForceThatWasHeld) {
  Body body(spring(300), 3);
  SimulatedDeviceSettings device;
  device.largest_force_N = 0.5;
  device.force_resolution_N = 0.05;
  for (const bool tells : {true, false}) {
    Rig rig(body, device, 0.03, [](phn_loop_settings& s) {
      s.largest_force_N = 8;
      s.force_resolution_N = 0;
      s.trip_energy_J = s.trip_force_N = 0;
    });
    rig.device.tells_held = tells;
    rig.run(5'000);
    const double gross = rig.device.energy().gross;
    if (tells) {
      EXPECT_LT(rig.largest_difference, 0.02 * gross);
    } else {
      EXPECT_GT(rig.largest_difference, 0.05 * gross);
    }
  }
}

}  // namespace
