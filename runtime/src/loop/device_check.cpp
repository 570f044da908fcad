#include "device_check.hpp"

namespace phynness::loop {

namespace {

/// Solves the 4 x 4 normal equations with partial pivoting. @return false if they are singular
bool solve(double (&a)[4][4], double (&b)[4][4]) {
  for (int k = 0; k < 4; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 4; ++i) pivot = std::fabs(a[i][k]) > std::fabs(a[pivot][k]) ? i : pivot;
    if (!(std::fabs(a[pivot][k]) > 1e-9)) return false;
    for (int j = 0; j < 4; ++j) {
      const double t = a[k][j];
      a[k][j] = a[pivot][j];
      a[pivot][j] = t;
    }
    for (int j = 0; j < 4; ++j) {
      const double t = b[k][j];
      b[k][j] = b[pivot][j];
      b[pivot][j] = t;
    }
    for (int i = 0; i < 4; ++i) {
      if (i == k) continue;
      const double factor = a[i][k] / a[k][k];
      for (int j = 0; j < 4; ++j) a[i][j] -= factor * a[k][j];
      for (int j = 0; j < 4; ++j) b[i][j] -= factor * b[k][j];
    }
  }
  return true;
}

constexpr double least_mobility = 0.1, largest_mobility = 500;  // 1/kg, for 1 N

}  // namespace

void DeviceCheck::restart() {
  *this = DeviceCheck(_force, _period);
  _passed = true;
  begin_axis(0);
}

void DeviceCheck::begin_axis(int axis) {
  if (axis != _axis) _attempts = 0;
  _axis = axis;
  _cycle = _n_samples = 0;
  // Heavy devices move by less than a step of their positions within short pulses.
  _eighth = cycles(_attempts < 10 ? 8e-3 : _attempts < 25 ? 16e-3 : 24e-3, 4);
  for (double& v : _squares) v = 0;
  // Natural frequencies of a hand with a device, and multiples of its critical damping.
  constexpr double frequency[] = {0, 60, 110, 200}, damping[] = {0.8, 1.6, 3.2, 6.4}, free[] = {0, 50, 200, 800};
  for (int i = 0; i < n_responses; ++i) {
    Response& r = _responses[i] = {};
    const double w = frequency[i / 4];
    r.stiffness = w * w;
    r.damping = i < 4 ? free[i] : damping[i % 4] * w;
  }
}

Vector DeviceCheck::next(double time) {
  if (finished()) return {};
  const bool measured = _cycle > 4 * _eighth && _newest >= _switch[3];
  if (measured || _cycle == 4 * _eighth + _longest_wait) {
    if (moved_as_pushed()) {
      begin_axis(_axis + 1);
    } else if (++_attempts < most_attempts) {
      begin_axis(_axis);
    } else {
      _passed = false;
      _axis = 3;
    }
    if (finished()) return {};
  }
  if (_cycle == 0) _switch[0] = time;
  if (_cycle == _eighth) _switch[1] = time;
  if (_cycle == 3 * _eighth) _switch[2] = time;
  if (_cycle == 4 * _eighth) _switch[3] = time;
  const int quarter = _cycle / _eighth;
  ++_cycle;
  const double f = quarter > 3 ? 0 : quarter == 0 || quarter == 3 ? _force : -_force;
  return {_axis == 0 ? f : 0, _axis == 1 ? f : 0, _axis == 2 ? f : 0};
}

/// The force of the pulses at a time, in units of their size.
double DeviceCheck::pulse(double time) const {
  const double sign[4] = {1, -2, 2, -1};
  const int n_switches = _cycle > 4 * _eighth ? 4 : _cycle > 3 * _eighth ? 3 : _cycle > _eighth ? 2 : 1;
  double force = 0;
  for (int i = 0; i < n_switches; ++i) force += time > _switch[i] ? sign[i] : 0;
  return force;
}

/// Integrates the responses with the implicit Euler method.
void DeviceCheck::advance(double time) {
  constexpr double longest_step = 2.5e-4;
  constexpr int most_steps = 1000;
  const double steps = std::ceil((time - _at) / longest_step);
  const int n = steps < 1 ? 1 : steps > most_steps ? most_steps : static_cast<int>(steps);
  const double dt = (time - _at) / n;
  for (int i = 0; i < n; ++i) {
    const double force = 1e5 * _force * pulse(_at + (i + 0.5) * dt);
    for (Response& r : _responses) {
      r.v = (r.v + dt * (force - r.stiffness * r.x)) / (1 + dt * r.damping + dt * dt * r.stiffness);
      r.x += dt * r.v;
    }
  }
  _at = time;
}

void DeviceCheck::sample(double time, Vector position) {
  _newest = time;
  if (finished() || _cycle == 0 || time < _switch[0]) return;
  // The hand moves meanwhile: a parabola is fitted beside the response. Time in units of 10 ms keeps the sums of one
  // order of magnitude.
  const double t = 1e2 * (time - _switch[0]), x[3] = {position.x, position.y, position.z};
  if (_n_samples == 0) _at = _switch[0];
  advance(time);
  for (int j = 0; j < 3; ++j) {
    if (_n_samples == 0) _first[j] = x[j];
    _squares[j] += (x[j] - _first[j]) * (x[j] - _first[j]);
  }
  for (Response& r : _responses) {
    const double base[4] = {1, t, t * t, r.x};
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) r.normal[i][j] += base[i] * base[j];
      for (int j = 0; j < 3; ++j) r.right[i][j] += base[i] * (x[j] - _first[j]);
    }
  }
  ++_n_samples;
}

/// Whether the mobilities of the response that fits best are inside their bounds by four standard errors: motions of
/// the hand are smooth, so that neighbouring residuals are alike.
bool DeviceCheck::moved_as_pushed() const {
  if (_n_samples < 2 * _eighth) return false;
  double best = -1;
  bool moved = false;
  for (const Response& r : _responses) {
    double normal[4][4], right[4][4];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        normal[i][j] = r.normal[i][j];
        right[i][j] = j < 3 ? r.right[i][j] : i == 3;
      }
    if (!solve(normal, right)) continue;
    double mobility[3], unsure[3], rest = 0;
    for (int j = 0; j < 3; ++j) {
      double left = _squares[j];
      for (int i = 0; i < 4; ++i) left -= right[i][j] / normal[i][i] * r.right[i][j];
      left = std::fmax(0.0, left);
      if (j == _axis) rest = left;
      mobility[j] = 1e5 * right[3][j] / normal[3][3];
      unsure[j] = 4e5 * std::sqrt(std::fmax(0.0, left / (_n_samples - 4) * right[3][3] / normal[3][3]));
    }
    if (best >= 0 && rest >= best) continue;
    best = rest;
    const double least = mobility[_axis] - unsure[_axis], most = mobility[_axis] + unsure[_axis];
    moved = least >= least_mobility && most <= largest_mobility;
    for (int j = 0; j < 3; ++j) moved &= j == _axis || std::fabs(mobility[j]) + unsure[j] < 0.5 * least;
  }
  return moved;
}

}  // namespace phynness::loop
