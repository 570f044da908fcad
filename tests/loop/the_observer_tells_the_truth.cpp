// Claim: the work of the observer is the true work of the forces on the device, up to 2 % of the exchanged energy or 20
// uJ, for any latency, jitter, losses, coupling, damping, motion and family. With an error of 2 % the energy at which
// the loop ends (1 mJ) is known within the allowance (20 uJ).
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
  EveryFifth combinations;
  int compared = 0, late = 0, missing = 0;
  for (const Family family : {Family::linear, Family::modal, Family::rbfn}) {
    Body body(family == Family::linear ? spring(150) : small_model_of(family), 3);
    for (const Point& point : points) {
      for (int latency = 0; latency <= 5; ++latency) {
        for (const double coupling : {100.0, 400.0, 2000.0}) {
          for (const double friction : {0.05, 2.0}) {
            if (combinations.skips()) continue;
            DeviceSettings device;
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
              if (!controlled) s.allowance_J = 1e3;
              s.trip_energy_J = s.trip_force_N = 0;
              s.trip_stale_s = 0.03;
            });
            rig.run(2'000);
            const double gross = rig.device.energy().gross;
            ASSERT_GT(gross, 1e-4);
            EXPECT_LT(rig.largest_difference, std::max(0.02 * gross, 2e-5))
                << name(family) << ' ' << point.name << " latency " << latency << " coupling " << coupling
                << " friction " << friction << " gross " << gross;
            const phn_loop_report report = rig.loop.report();
            late += static_cast<int>(report.late);
            missing += static_cast<int>(report.missing);
            ++compared;
          }
        }
      }
    }
  }
  EXPECT_EQ(compared, 3 * 5 * 6 * 3 * 2 / 5);
  EXPECT_GT(late, 40);
  EXPECT_GT(missing, 200);
}

}  // namespace
