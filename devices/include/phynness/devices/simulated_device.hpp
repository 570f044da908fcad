// A simulated hand that holds a simulated device. The hand is a spring and a damper towards a motion, the device a mass
// with friction. Positions are rounded and arrive late, forces are limited and rounded, as settings say. The device
// counts the true energies, with which a passivity observer can be compared.
#pragma once

#include <phynness/devices/device.hpp>

#include <deque>
#include <functional>
#include <random>
#include <vector>

namespace phynness::devices {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};

/// The position that the hand wants to reach, as a function of time.
class HandMotion {
 public:
  /// At rest at 0.
  HandMotion() = default;
  /// Presses, circles, tremor and, every ten seconds, three taps within `reach_m` of 0, for ever.
  explicit HandMotion(double reach_m) : _reach_m(reach_m) {}
  /// Recorded positions x y z [m], one line per millisecond, repeated for ever.
  /// @throws std::runtime_error  with file and line
  static HandMotion recorded(const std::string& file);
  Vector3 at(double time_s) const;

 private:
  double _reach_m = 0;
  std::vector<Vector3> _positions;
};

struct SimulatedDeviceSettings {
  double mass_kg = 0.08, friction_Ns_per_m = 0.5;
  double hand_stiffness_N_per_m = 250, hand_damping_Ns_per_m = 4;  ///< 0: nobody holds the device
  double resolution_m = 2e-5;                                      ///< of the positions
  double largest_force_N = 8, force_resolution_N = 0;
  double period_s = 1e-3;
  bool has_times = true;
  int latency_samples = 1;     ///< complete periods between measurement and arrival
  double late_s = 0;           ///< further delay of single samples, up to this
  double jitter_s = 0;         ///< the measurement is up to this earlier than the end of a period
  double lost = 0, twice = 0;  ///< shares of samples that never arrive or arrive twice
  unsigned seed = 1;
};

/// Energies [J], integrated together with the motion.
struct TrueEnergy {
  double delivered = 0;       ///< by the forces of the loop to the device
  double most_delivered = 0;  ///< largest value of `delivered`
  double gross = 0;           ///< integral of |force . velocity|
  double to_hand = 0;         ///< that the hand received
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
  /// The sums of energy() begin again at zero.
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
