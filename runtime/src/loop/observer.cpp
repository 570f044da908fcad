#include "observer.hpp"

namespace phynness::loop {

double QuantizedCoordinate::next(double time, double period, double measured) {
  const double step = measured - _measured;
  if (!_started || !(_resolution > 0) || std::fabs(step) > 1.5 * _resolution) {
    _direction = _started && step < 0 ? -1 : 1;
    _edge = measured - 0.5 * _resolution * _direction;
    _step_time = 0;
    _changed_at = time;
  } else if (step != 0) {
    const double direction = step > 0 ? 1 : -1;
    _step_time = direction == _direction ? time - _changed_at : -1;
    _edge = measured - 0.5 * step;
    _direction = direction;
    _changed_at = time;
  }
  _started = true;
  _measured = measured;
  if (_step_time < 0) return _edge;
  // The step began within the last period.
  const double since = time - _changed_at + 0.5 * period;
  const double part = !(_step_time > 0) ? 0.5 : since < _step_time ? since / _step_time : 1;
  return _edge + part * _resolution * _direction;
}

void Observer::hold(double from, Vector force) {
  if (_n_held == 0 || from > _held[_newest].from) {
    _newest = (_newest + 1) % n_stored;
    if (_n_held < n_stored) ++_n_held;
  }
  _held[_newest] = {from, force};
}

bool Observer::sample(double time, Vector measured) {
  if (started() && !is_newer(time)) return false;
  _measured = measured;
  Vector position;
  for (int k = 0; k < 3; ++k) position[k] = _coordinates[k].next(time, _period, measured[k]);
  if (started()) {
    const double duration = time - _samples[0].time;
    const Vector moved = position - _samples[0].position, velocity = (1 / duration) * moved;
    Vector impulse = {};
    each_force(_samples[0].time, time,
               [&](const Held& held, double seconds) { impulse = impulse + seconds * held.force; });
    work -= dot(impulse, velocity);
    if (-work > largest_delivered) largest_delivered = -work;  // not -0, which fmax may return
    if (duration > 1.5 * _period) {
      // It is not known during which of the forces of a gap the device moved. It may have moved during one of them
      // only.
      double largest = 0;
      each_force(_samples[0].time, time, [&](const Held& held, double) {
        largest = std::fmax(largest, std::fabs(dot(held.force - (1 / duration) * impulse, moved)));
      });
      work_error += largest;
    }
    // The motion is measured over sixteen intervals, because steps of the positions would count as motion in each.
    const double long_duration = time - _window.time;
    if (long_duration >= 15.5 * _period) {
      const double distance = std::fmax(0.0, length(position - _window.position) - 1.8 * _resolution);
      dissipated += _damping * distance * distance / long_duration;
      _window = {time, position};
    }
  } else {
    _window = {time, position};
  }
  for (int i = 4; i > 0; --i) _samples[i] = _samples[i - 1];
  _samples[0] = {time, position};
  if (_n_samples < 5) ++_n_samples;
  return true;
}

void Observer::restart() {
  work = largest_delivered = work_error = dissipated = 0;
  _window = _samples[0];
}

Vector Observer::velocity(int n) const {
  const int last = n < _n_samples ? n : _n_samples - 1;
  if (last < 1) return {};
  return (1 / (_samples[0].time - _samples[last].time)) * (_samples[0].position - _samples[last].position);
}

double Observer::pending(Vector velocity, double until) const {
  double energy = 0;
  if (!started()) return 0;
  each_force(_samples[0].time, until,
             [&](const Held& held, double seconds) { energy += seconds * dot(held.force, velocity); });
  return energy;
}

}  // namespace phynness::loop
