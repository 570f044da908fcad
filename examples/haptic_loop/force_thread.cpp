#include "force_thread.hpp"

#include <algorithm>

namespace {

/// Solves (K + k I) x = b for symmetric K and k so large that the matrix is positive definite.
Vector3 solve(const double* K, double k, Vector3 b) {
  const double a = K[0] + k, d = K[4] + k, f = K[8] + k, p = K[1], q = K[2], r = K[5];
  const double c00 = d * f - r * r, c01 = q * r - p * f, c02 = p * r - q * d;
  const double det = a * c00 + p * c01 + q * c02;
  return (1 / det) * Vector3{c00 * b.x + c01 * b.y + c02 * b.z,
                             c01 * b.x + (a * f - q * q) * b.y + (p * q - a * r) * b.z,
                             c02 * b.x + (p * q - a * r) * b.y + (a * d - p * p) * b.z};
}

}  // namespace

ForceThread::ForceThread(const LoopSettings& settings, const phn_model* model, phn_data* data, int32_t node)
    : _settings(settings), _model(model), _data(data), _node(node) {
  const double h = settings.largest_displacement_m > 0 ? settings.largest_displacement_m / 10 : 1e-3;
  phn_info info;
  phn_model_info(model, &info);
  _has_stiffness = info.has_energy != 0;
  double slope[9];
  for (int k = 0; k < 3; ++k) {
    double to[3] = {}, from[3] = {}, f[3] = {}, g[3] = {};
    to[k] = h;
    from[k] = -h;
    phn_force(model, data, node, to, f, nullptr, nullptr);
    phn_force(model, data, node, from, g, nullptr, nullptr);
    for (int i = 0; i < 3; ++i) slope[3 * i + k] = (f[i] - g[i]) / (2 * h);
  }
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) _rest_stiffness[3 * i + k] = (slope[3 * i + k] + slope[3 * k + i]) / 2;
}

ForceThread::ForceThread(const LoopSettings& settings, const phn_model* model, TouchingTool& touching)
    : _settings(settings), _model(model), _touching(&touching) {}

void ForceThread::follow_touching(Vector3 position) {
  _tool = _touching->follow(position, _tool, _settings.coupling_stiffness_N_per_m, _settings.largest_displacement_m);
  _warnings += _touching->status() > 0;
}

void ForceThread::follow(Vector3 position) {
  const double d[3] = {_tool.x, _tool.y, _tool.z};
  double force[3] = {}, stiffness[9] = {};
  const int status = phn_force(_model, _data, _node, d, force, nullptr, _has_stiffness ? stiffness : nullptr);
  _warnings += status > 0;
  // Networks have no stiffness, so that the stiffness at rest is used. The iteration converges if the stiffness of the
  // touched tissue is at most twice the sum of this stiffness and that of the coupling.
  if (!_has_stiffness || status < 0) std::copy(_rest_stiffness, _rest_stiffness + 9, stiffness);
  const double k = _settings.coupling_stiffness_N_per_m;
  const Vector3 unbalanced = k * (position - _tool) - Vector3{force[0], force[1], force[2]};
  // If the softening of the tissue exceeds the stiffness of the coupling, the step uses the coupling alone.
  const double softest = std::min({stiffness[0], stiffness[4], stiffness[8]});
  const bool safe = softest > -0.5 * k;
  Vector3 next = _tool + (safe ? solve(stiffness, k, unbalanced) : (0.5 / k) * unbalanced);
  const double size = length(next);
  if (_settings.largest_displacement_m > 0 && size > _settings.largest_displacement_m)
    next = (_settings.largest_displacement_m / size) * next;
  _tool = next;
}

Vector3 ForceThread::kept_passive(Vector3 force, Vector3 moved) {
  // The force of the last cycle acted while the hand moved (Hannaford & Ryu 2002, doi 10.1109/70.988969).
  _work -= dot(_last_force, moved);
  _most_generated = std::max(_most_generated, -_work);
  const double speed2 = dot(moved, moved) / (_settings.period_s * _settings.period_s);
  if (!_settings.passivity_controller || _work >= 0 || !(speed2 > 0)) return force;
  const double damping = std::min(-_work / (_settings.period_s * speed2), _settings.largest_damping_Ns_per_m);
  return force - (damping / _settings.period_s) * moved;
}

Vector3 ForceThread::step(Vector3 position, long taken, long cycle) {
  Vector3 force;
  if (cycle - taken > _settings.stale_cycles) {
    ++_stale;
    _last_force = {};
    _last_position = position;
    return force;
  }
  if (!_started) _last_position = position;
  if (!_started && _touching) _tool = position;
  _started = true;
  const Vector3 moved = position - _last_position, tool_before = _tool;
  if (_touching) {
    follow_touching(position);
  } else {
    follow(position);
  }
  const Vector3 slip = (moved - (_tool - tool_before));
  force = _settings.coupling_stiffness_N_per_m * (_tool - position) -
          (_settings.coupling_damping_Ns_per_m / _settings.period_s) * slip;
  force = kept_passive(force, moved);
  _last_position = position;
  _last_force = force;
  Touch touch;
  touch.displacement = _tool;
  touch.cycle = cycle;
  touch.anywhere = _touching != nullptr;
  if (_touching) touch.held = _touching->held();
  _touch.write(touch);
  return force;
}
