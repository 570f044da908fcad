#include "simulated_device.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

HandMotion HandMotion::recorded(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": the recorded motion cannot be read");
  HandMotion motion(0);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    Vector3 p;
    if (!(words >> p.x >> p.y >> p.z) || !std::isfinite(p.x + p.y + p.z))
      throw std::runtime_error(file + ":" + std::to_string(number) + ": not three numbers: " + line);
    motion._positions.push_back(p);
  }
  if (motion._positions.empty()) throw std::runtime_error(file + ": no line holds a position");
  return motion;
}

Vector3 HandMotion::at(long cycle) const {
  if (!_positions.empty()) return _positions[static_cast<std::size_t>(cycle) % _positions.size()];
  // Frequencies of a hand: slow presses, circles, a tremor of 9 Hz, and every ten seconds three taps within 50 ms each.
  const double t = 1e-3 * static_cast<double>(cycle), two_pi = 6.283185307179586;
  const double press = 0.5 - 0.5 * std::cos(two_pi * 0.4 * t), turn = two_pi * 0.9 * t;
  Vector3 p{0.35 * std::cos(turn) * press, 0.35 * std::sin(turn) * press, -0.8 * press};
  p.x += 0.01 * std::sin(two_pi * 9 * t);
  const double since = std::fmod(t, 10.0);
  if (since < 0.6 && std::fmod(since, 0.2) < 0.05) p.z -= 0.2;
  return _reach_m * p;
}

void SimulatedDevice::hold(Vector3 force, bool stalled) {
  const double size = length(force);
  if (size > _settings.largest_force_N) force = (_settings.largest_force_N / size) * force;
  constexpr int steps = 10;  // the mechanics have shorter time scales than a millisecond
  constexpr double dt = 1e-3 / steps;
  const Vector3 before = _motion.at(_cycle), wanted_velocity = 1e3 * (_motion.at(_cycle + 1) - before);
  for (int i = 0; i < steps; ++i) {
    const Vector3 wanted = before + (i * dt) * wanted_velocity;
    const Vector3 hand = _settings.hand_stiffness_N_per_m * (wanted - _position) +
                         _settings.hand_damping_Ns_per_m * (wanted_velocity - _velocity);
    _velocity = _velocity + (dt / _settings.mass_kg) * (hand + force - _settings.friction_Ns_per_m * _velocity);
    _position = _position + dt * _velocity;
  }
  ++_cycle;
  if (stalled) return;
  const auto rounded = [&](double x) { return _settings.resolution_m * std::round(x / _settings.resolution_m); };
  _delayed = _taken;
  _taken = {{rounded(_position.x), rounded(_position.y), rounded(_position.z)}, _cycle};
}
