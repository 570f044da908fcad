#include <phynness/devices/simulated_device.hpp>

#include <algorithm>
#include <cmath>

namespace phynness::devices {

namespace {

Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
double dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

constexpr int n_steps = 10;  // per period; the fastest rate, hand damping / mass, is 1/20 per step

Vector3 rounded(Vector3 v, double step) {
  if (!(step > 0)) return v;
  return {step * std::round(v.x / step), step * std::round(v.y / step), step * std::round(v.z / step)};
}

}  // namespace

Vector3 HandMotion::at(double time_s) const {
  if (_function) return _function(time_s);
  if (!(_reach_m > 0)) return {};
  // Frequencies of a hand: slow presses, circles, and a tremor of 9 Hz. Three taps every ten seconds, each a step in
  // and out within 50 ms that rises within 2 ms.
  const double two_pi = 6.283185307179586;
  const double press = 0.5 - 0.5 * std::cos(two_pi * 0.4 * time_s), turn = two_pi * 0.9 * time_s;
  Vector3 p{0.35 * std::cos(turn) * press, 0.35 * std::sin(turn) * press, -0.8 * press};
  p.x += 0.01 * std::sin(two_pi * 9 * time_s);
  const double since = std::fmod(time_s, 10.0), in_tap = std::fmod(since, 0.2);
  if (since < 0.6 && in_tap < 0.05) p.z -= 0.2 * std::min({1.0, in_tap / 2e-3, (0.05 - in_tap) / 2e-3});
  return _reach_m * p;
}

SimulatedDevice::SimulatedDevice(const SimulatedDeviceSettings& settings, HandMotion motion)
    : _settings(settings), _motion(std::move(motion)), _random(settings.seed) {
  _arrivals.push_back({0, {{0, 0, 0}, -_settings.latency_samples * _settings.period_s}});  // rests since long
}

Traits SimulatedDevice::traits() const {
  Traits t;
  t.name = "simulated device";
  t.period_s = _settings.period_s;
  t.has_times = _settings.has_times;
  t.latency_s = _settings.latency_samples * _settings.period_s;
  t.position_resolution_m = _settings.resolution_m;
  t.damping_Ns_per_m = 0;  // no damping is guaranteed
  t.largest_force_N = _settings.largest_force_N;
  t.force_resolution_N = _settings.force_resolution_N;
  return t;
}

bool SimulatedDevice::read(phn_loop_sample& sample) {
  // Of several arrivals the last one, which may not be the newest measurement.
  auto last = _arrivals.end();
  for (auto i = _arrivals.begin(); i != _arrivals.end(); ++i)
    if (i->at <= _time + 1e-9 && (last == _arrivals.end() || i->at >= last->at)) last = i;
  if (last == _arrivals.end()) return false;
  sample = last->sample;
  const double arrived = last->at;
  _arrivals.erase(std::remove_if(_arrivals.begin(), _arrivals.end(), [&](const Arrival& a) { return a.at <= arrived; }),
                  _arrivals.end());
  return true;
}

Vector3 SimulatedDevice::applied(const State& s, Vector3 force) const {
  return force_fault ? force_fault(force, s.position, s.velocity) : force;
}

SimulatedDevice::State SimulatedDevice::derivative(const State& s, double time, Vector3 force) const {
  constexpr double h = 1e-6;
  const Vector3 wanted = _motion.at(time), wanted_velocity = (1 / h) * (_motion.at(time + h) - wanted);
  const Vector3 hand = _settings.hand_stiffness_N_per_m * (wanted - s.position) +
                       _settings.hand_damping_Ns_per_m * (wanted_velocity - s.velocity);
  const Vector3 motors = applied(s, force);
  State rate;
  rate.position = s.velocity;
  rate.velocity = (1 / _settings.mass_kg) * (hand + motors - _settings.friction_Ns_per_m * s.velocity);
  rate.delivered = dot(motors, s.velocity);
  rate.dissipated = _settings.friction_Ns_per_m * dot(s.velocity, s.velocity);
  return rate;
}

/// One step of the classical fourth-order Runge-Kutta method.
SimulatedDevice::State SimulatedDevice::after(const State& s, double time, double dt, Vector3 force) const {
  const auto moved = [](const State& a, double by, const State& rate) {
    return State{a.position + by * rate.position, a.velocity + by * rate.velocity, a.delivered + by * rate.delivered,
                 a.dissipated + by * rate.dissipated};
  };
  const State a = derivative(s, time, force), b = derivative(moved(s, dt / 2, a), time + dt / 2, force),
              c = derivative(moved(s, dt / 2, b), time + dt / 2, force),
              d = derivative(moved(s, dt, c), time + dt, force);
  return moved(moved(moved(moved(s, dt / 6, a), dt / 3, b), dt / 3, c), dt / 6, d);
}

void SimulatedDevice::count(const State& before, const State& now) {
  _energy.gross += std::fabs(now.delivered - before.delivered);
  _energy.delivered = now.delivered;
  _energy.most_delivered = std::max(_energy.most_delivered, _energy.delivered);
  const double kinetic = 0.5 * _settings.mass_kg * dot(now.velocity, now.velocity);
  // The kinetic energy at the beginning of the count was supplied by the hand.
  _energy.to_hand = now.delivered - now.dissipated - kinetic;
  _energy.most_to_hand = std::max(_energy.most_to_hand, _energy.to_hand);
}

void SimulatedDevice::count_energy_from_now() {
  _energy = {};
  _state.delivered = _state.dissipated = 0;
}

void SimulatedDevice::measure(const std::vector<State>& steps) {
  std::uniform_real_distribution<double> share(0, 1);
  const double dt = _settings.period_s / n_steps;
  const int early = std::min(n_steps - 1, static_cast<int>(std::lround(share(_random) * _settings.jitter_s / dt)));
  const double late = share(_random) * _settings.late_s;
  const bool lost = share(_random) < _settings.lost, twice = share(_random) < _settings.twice;
  if (_stalled > 0) {
    --_stalled;
    return;
  }
  if (lost) return;
  Vector3 p = steps[static_cast<std::size_t>(n_steps - early)].position;
  if (position_fault) p = position_fault(p);
  p = rounded(p, _settings.resolution_m);
  Arrival arrival{_time + _settings.latency_samples * _settings.period_s + late, {{p.x, p.y, p.z}, _time - early * dt}};
  _arrivals.push_back(arrival);
  if (twice) {
    arrival.at += _settings.period_s;
    _arrivals.push_back(arrival);
  }
}

void SimulatedDevice::hold(const double f[3]) {
  Vector3 force{f[0], f[1], f[2]};
  const double size = std::sqrt(dot(force, force));
  if (size > _settings.largest_force_N) force = (_settings.largest_force_N / size) * force;
  force = rounded(force, _settings.force_resolution_N);
  const Vector3 begins = applied(_state, force);
  _held[0] = begins.x;
  _held[1] = begins.y;
  _held[2] = begins.z;
  const double dt = _settings.period_s / n_steps;
  std::vector<State>& steps = _steps;
  steps.assign(1, _state);
  for (int i = 0; i < n_steps; ++i) {
    steps.push_back(after(steps.back(), _time + i * dt, dt, force));
    count(steps[static_cast<std::size_t>(i)], steps.back());
  }
  _state = steps.back();
  _time = static_cast<double>(++_cycle) * _settings.period_s;
  measure(steps);
}

bool SimulatedDevice::held(double force[3]) {
  std::copy(_held, _held + 3, force);
  return tells_held;
}

}  // namespace phynness::devices
