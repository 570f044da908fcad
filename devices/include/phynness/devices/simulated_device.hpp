// A simulated hand that holds a simulated device. The hand is a spring and a damper to an intended motion; the device
// is a mass with friction. According to the settings positions are rounded and delayed, and forces are limited and
// rounded. The device integrates the true energies, with which a passivity observer can be compared.
#pragma once

#include <phynness/devices/device.hpp>

#include <deque>
#include <functional>
#include <random>
#include <utility>
#include <vector>

namespace phynness::devices {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};

/// The intended position of the hand as a function of time.
class HandMotion {
 public:
  /// Constant position 0.
  HandMotion() = default;
  /// Endless presses, circles and tremor, with three taps every ten seconds, within `reach_m` of 0.
  explicit HandMotion(double reach_m) : _reach_m(reach_m) {}
  /// The position as a function of the time [s].
  explicit HandMotion(std::function<Vector3(double)> at) : _function(std::move(at)) {}
  Vector3 at(double time_s) const;

 private:
  double _reach_m = 0;
  std::function<Vector3(double)> _function;
};

struct SimulatedDeviceSettings {
  double mass_kg = 0.08, friction_Ns_per_m = 0.5;
  double hand_stiffness_N_per_m = 250, hand_damping_Ns_per_m = 4;  ///< 0: the device is not held
  double resolution_m = 2e-5;                                      ///< of the positions
  double largest_force_N = 8, force_resolution_N = 0;
  double period_s = 1e-3;
  bool has_times = true;
  int latency_samples = 1;     ///< complete periods between measurement and arrival
  double late_s = 0;           ///< largest additional delay of single samples
  double jitter_s = 0;         ///< largest time between a measurement and the end of its period
  double lost = 0, twice = 0;  ///< fractions of samples that are lost or arrive twice
  unsigned seed = 1;
};

/// Energies [J], integrated together with the motion.
struct TrueEnergy {
  double delivered = 0;       ///< to the device by the forces of the loop
  double most_delivered = 0;  ///< largest value of `delivered`
  double gross = 0;           ///< integral of |force . velocity|
  double to_hand = 0;         ///< received by the hand
  double most_to_hand = 0;    ///< largest value of `to_hand`
};

class SimulatedDevice : public Device {
 public:
  SimulatedDevice(const SimulatedDeviceSettings& settings, HandMotion motion);

  void open() override {}
  Traits traits() const override;
  double now() override { return _time; }
  bool wait() override { return true; }
  bool read(phn_loop_sample& sample) override;
  /// Simulates one period.
  void hold(const double force[3]) override;
  bool held(double force[3]) override;
  void close() noexcept override {}

  const TrueEnergy& energy() const { return _energy; }
  /// Restarts the sums of energy() at zero.
  void count_energy_from_now();
  Vector3 position() const { return _state.position; }
  /// No positions arrive for so many periods from now on.
  void stall(int periods) { _stalled = periods; }
  /// Faults: the force on the device instead of that of hold(), and the position that is measured instead of the true
  /// one. Empty: none.
  std::function<Vector3(Vector3 force, Vector3 position, Vector3 velocity)> force_fault;
  std::function<Vector3(Vector3 position)> position_fault;
  /// held() tells the faulty force, as a device with force sensors would.
  bool tells_held = true;

 private:
  struct State {
    Vector3 position, velocity;
    double delivered = 0, dissipated = 0;
  };
  struct Arrival {
    double at = 0;
    phn_loop_sample sample{};
  };
  State derivative(const State& s, double time, Vector3 force) const;
  State after(const State& s, double time, double dt, Vector3 force) const;
  void count(const State& before, const State& now);
  void measure(const std::vector<State>& steps);
  Vector3 applied(const State& s, Vector3 force) const;

  SimulatedDeviceSettings _settings;
  HandMotion _motion;
  std::mt19937 _random;
  State _state;
  double _time = 0;
  long _cycle = 0;
  int _stalled = 0;
  double _held[3] = {};
  std::deque<Arrival> _arrivals;
  std::vector<State> _steps;  ///< of the last period
  TrueEnergy _energy;
};

}  // namespace phynness::devices
