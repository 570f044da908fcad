// The whole chain: loop, adapter, socket, and a device that the service simulates as a mass that a hand moves. The loop
// engages, its test pulses pass, and the work that its observer counts is the work that the service counted: at most 2
// % of the gross energy exchanged or 20 uJ, the greater, apart. Each cycle is one message and one simulated
// millisecond, and the loop gets the simulated time, so that nothing depends on how long anything takes.
#include "inverse_service.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace phynness::devices {
namespace {

constexpr double period_s = 1e-3;

class LoopOverSocket {
 public:
  explicit LoopOverSocket(HaplyInverse& device) : _device(device) {
    phn_loop_settings settings = settings_for(device.traits());
    settings.origin_m[1] = 0.12;  // the service moves its device around (0, -0.12, 0.15)
    settings.origin_m[2] = -0.15;
    std::size_t bytes = 0;
    phn_loop_size(&bytes);
    _memory.resize(bytes / sizeof(double) + 2);
    EXPECT_EQ(phn_loop_init(_memory.data(), _memory.size() * sizeof(double), &settings, &_loop), 0);
    EXPECT_TRUE(device.read(_sample));
  }
  phn_loop* loop() { return _loop; }

  /// One millisecond with a spring of 300 N/m that holds the tool. @return false if the connection is lost
  bool cycle() {
    const double time = period_s * _cycle;
    double tool[3], force[3];
    phn_loop_response response{};
    _sample.time_s = time;
    phn_loop_read(_loop, &_sample, time, tool);
    response.in_contact = response.has_stiffness = 1;
    for (int i = 0; i < 3; ++i) {
      response.force[i] = 300 * tool[i];
      response.stiffness[4 * i] = 300;
      response.displacement[i] = tool[i];
      response.energy += 150 * tool[i] * tool[i];
    }
    phn_loop_hold(_loop, &response, time, force);
    ++_cycle;
    return exchange(_device, {force[0], force[1], force[2]}, _sample);
  }
  phn_loop_report report() const {
    phn_loop_report r;
    phn_loop_get_report(_loop, &r);
    return r;
  }

 private:
  HaplyInverse& _device;
  std::vector<double> _memory;
  phn_loop* _loop = nullptr;
  phn_loop_sample _sample{};
  int _cycle = 0;
};

TEST(LoopOverInverseService, EngagesAndCountsTheWorkOfTheDevice) {
  InverseService service;
  service.settings.largest_force_N = 2;
  HaplyInverse device(service.settings);
  device.open();
  LoopOverSocket chain(device);
  ASSERT_EQ(phn_loop_engage(chain.loop()), 0);
  for (int i = 0; i < 3000; ++i) ASSERT_TRUE(chain.cycle()) << device.lost();
  const phn_loop_report r = chain.report();
  EXPECT_EQ(r.state, PHN_LOOP_ON) << phn_loop_trip_message(r.trip);
  EXPECT_GT(r.gross_J, 1e-3) << "forces and motion must be such that the comparison says something";
  device.close();
  EXPECT_EQ(service.finish(), 0);
  const std::string log = service.log();
  const std::size_t at = log.find("work on the device");
  ASSERT_NE(at, std::string::npos);
  double work = 0, gross = 0;
  ASSERT_EQ(std::sscanf(log.c_str() + at, "work on the device %lf J, gross %lf J", &work, &gross), 2);
  EXPECT_NEAR(r.work_J, -work, std::max(0.02 * gross, 2e-5)) << "gross " << gross;
  RecordProperty("work_J", std::to_string(r.work_J));
}

TEST(LoopOverInverseService, AServiceThatIgnoresForcesIsFoundBeforeTheLoopIsOn) {
  InverseService service("--force-name other --ignores-forces");
  HaplyInverse device(service.settings);
  device.open();
  LoopOverSocket chain(device);
  ASSERT_EQ(phn_loop_engage(chain.loop()), 0);
  ASSERT_TRUE(chain.cycle());
  for (int i = 0; i < 5000 && chain.report().state == PHN_LOOP_CHECKING; ++i)
    ASSERT_TRUE(chain.cycle()) << device.lost();
  EXPECT_EQ(chain.report().state, PHN_LOOP_TRIPPED);
  EXPECT_EQ(chain.report().trip, PHN_TRIP_CHECK) << phn_loop_trip_message(chain.report().trip);
}

}  // namespace
}  // namespace phynness::devices
