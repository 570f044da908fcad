// A simulated hand that holds a simulated device. The hand is a spring and a damper to an intended motion; the device
// is a mass with friction. Positions are rounded and delayed. The device integrates the true energies, with which the
// observer is compared.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>
#include <utility>
#include <vector>

namespace phynness::test {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};
inline Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// The intended position of the hand as a function of time [s].
using HandMotion = std::function<Vector3(double)>;

/// Endless presses, circles and tremor, with three taps every ten seconds, within `reach_m` of 0.
inline HandMotion busy_hand(double reach_m) {
  return [reach_m](double time_s) -> Vector3 {
    // Frequencies of a hand: slow presses, circles, and a tremor of 9 Hz. Each tap is a step in and out within 50 ms
    // that rises within 2 ms.
    const double two_pi = 6.283185307179586;
    const double press = 0.5 - 0.5 * std::cos(two_pi * 0.4 * time_s), turn = two_pi * 0.9 * time_s;
    Vector3 p{0.35 * std::cos(turn) * press, 0.35 * std::sin(turn) * press, -0.8 * press};
    p.x += 0.01 * std::sin(two_pi * 9 * time_s);
    const double since = std::fmod(time_s, 10.0), in_tap = std::fmod(since, 0.2);
    if (since < 0.6 && in_tap < 0.05) p.z -= 0.2 * std::min({1.0, in_tap / 2e-3, (0.05 - in_tap) / 2e-3});
    return reach_m * p;
  };
}

struct DeviceSettings {
  double mass_kg = 0.08, friction_Ns_per_m = 0.5;
  double hand_stiffness_N_per_m = 250, hand_damping_Ns_per_m = 4;
  double resolution_m = 2e-5;  ///< of the positions
  int latency_samples = 1;     ///< complete periods between measurement and arrival
  double late_s = 0;           ///< largest additional delay of single samples
  double jitter_s = 0;         ///< largest time between a measurement and the end of its period
  double lost = 0, twice = 0;  ///< fractions of samples that are lost or arrive twice
};

/// Energies [J], integrated together with the motion.
struct TrueEnergy {
  double delivered = 0;       ///< to the device by the forces of the loop
  double most_delivered = 0;  ///< largest value of `delivered`
  double gross = 0;           ///< integral of |force . velocity|
  double most_to_hand = 0;    ///< largest energy that the hand has received
};

class SimulatedDevice {
 public:
  struct Sample {
    double position[3] = {}, time_s = 0;
  };
  SimulatedDevice(const DeviceSettings& settings, HandMotion motion) : _settings(settings), _motion(std::move(motion)) {
    _arrivals.push_back({0, {{0, 0, 0}, -_settings.latency_samples * period_s}});  // rests since long
  }
  double now() const { return _time; }
  Vector3 position() const { return _state.position; }
  const TrueEnergy& energy() const { return _energy; }

  /// Of several arrivals the last one, which may not be the newest measurement.
  bool read(Sample& sample) {
    auto last = _arrivals.end();
    for (auto i = _arrivals.begin(); i != _arrivals.end(); ++i)
      if (i->at <= _time + 1e-9 && (last == _arrivals.end() || i->at >= last->at)) last = i;
    if (last == _arrivals.end()) return false;
    sample = last->sample;
    std::erase_if(_arrivals, [arrived = last->at](const Arrival& a) { return a.at <= arrived; });
    return true;
  }

  /// Simulates one period.
  void hold(Vector3 force) {
    const double dt = period_s / n_steps;
    std::vector<State> steps{_state};
    for (int i = 0; i < n_steps; ++i) {
      steps.push_back(after(steps.back(), _time + i * dt, dt, force));
      count(steps[static_cast<std::size_t>(i)], steps.back());
    }
    _state = steps.back();
    _time = static_cast<double>(++_cycle) * period_s;
    measure(steps);
  }

  /// The position that is measured instead of the true one.
  std::function<Vector3(Vector3 position)> position_fault;
  int stalled = 0;  ///< periods from which no positions arrive

  static constexpr double period_s = 1e-3;

 private:
  static constexpr int n_steps = 10;  // per period; the fastest rate, hand damping / mass, is 1/20 per step
  struct State {
    Vector3 position, velocity;
    double delivered = 0, dissipated = 0;
  };
  struct Arrival {
    double at = 0;
    Sample sample;
  };

  State derivative(const State& s, double time, Vector3 force) const {
    constexpr double h = 1e-6;
    const Vector3 wanted = _motion(time), wanted_velocity = (1 / h) * (_motion(time + h) - wanted);
    const Vector3 hand = _settings.hand_stiffness_N_per_m * (wanted - s.position) +
                         _settings.hand_damping_Ns_per_m * (wanted_velocity - s.velocity);
    return {s.velocity, (1 / _settings.mass_kg) * (hand + force - _settings.friction_Ns_per_m * s.velocity),
            dot(force, s.velocity), _settings.friction_Ns_per_m * dot(s.velocity, s.velocity)};
  }
  /// One step of the classical fourth-order Runge-Kutta method.
  State after(const State& s, double time, double dt, Vector3 force) const {
    const auto moved = [](const State& a, double by, const State& rate) {
      return State{a.position + by * rate.position, a.velocity + by * rate.velocity, a.delivered + by * rate.delivered,
                   a.dissipated + by * rate.dissipated};
    };
    const State a = derivative(s, time, force), b = derivative(moved(s, dt / 2, a), time + dt / 2, force),
                c = derivative(moved(s, dt / 2, b), time + dt / 2, force),
                d = derivative(moved(s, dt, c), time + dt, force);
    return moved(moved(moved(moved(s, dt / 6, a), dt / 3, b), dt / 3, c), dt / 6, d);
  }
  void count(const State& before, const State& now) {
    _energy.gross += std::fabs(now.delivered - before.delivered);
    _energy.delivered = now.delivered;
    _energy.most_delivered = std::max(_energy.most_delivered, now.delivered);
    const double kinetic = 0.5 * _settings.mass_kg * dot(now.velocity, now.velocity);
    _energy.most_to_hand = std::max(_energy.most_to_hand, now.delivered - now.dissipated - kinetic);
  }
  void measure(const std::vector<State>& steps) {
    std::uniform_real_distribution<double> share(0, 1);
    const double dt = period_s / n_steps;
    const int early = std::min(n_steps - 1, static_cast<int>(std::lround(share(_random) * _settings.jitter_s / dt)));
    const double late = share(_random) * _settings.late_s;
    const bool lost = share(_random) < _settings.lost, twice = share(_random) < _settings.twice;
    if (stalled > 0) --stalled;
    if (stalled > 0 || lost) return;
    const Vector3 at = steps[static_cast<std::size_t>(n_steps - early)].position,
                  p = position_fault ? position_fault(at) : at;
    const double step = _settings.resolution_m;
    const auto rounded = [step](double x) { return step > 0 ? step * std::round(x / step) : x; };
    Arrival arrival{_time + _settings.latency_samples * period_s + late,
                    {{rounded(p.x), rounded(p.y), rounded(p.z)}, _time - early * dt}};
    _arrivals.push_back(arrival);
    arrival.at += period_s;
    if (twice) _arrivals.push_back(arrival);
  }

  DeviceSettings _settings;
  HandMotion _motion;
  std::mt19937 _random{1};
  State _state;
  double _time = 0;
  long _cycle = 0;
  std::deque<Arrival> _arrivals;
  TrueEnergy _energy;
};

}  // namespace phynness::test
