// Passivity observer: the work that the device did on the loop, from the forces that it held and the positions that it
// measured, each with its time.
#pragma once

#include "tools/vectors.hpp"

namespace phynness::loop {

using runtime::Matrix, runtime::Vector, runtime::vector_at;

inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }
inline bool equal(const Vector& a, const Vector& b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }
inline void store(const Vector& a, double* v) {
  for (int k = 0; k < 3; ++k) v[k] = a[k];
}
/// a, shortened to `longest`.
inline Vector limited_length(Vector a, double longest) {
  const double size = length(a);
  return size > longest ? (longest / size) * a : a;
}

/// Estimate of a coordinate that is measured in steps. While the measurement changes back and forth between two
/// neighbouring values, the estimate stays where they meet. Otherwise it starts there at each change and moves on as
/// fast as before, up to the next value. It has no jumps that would count as work, and a hand at rest has a constant
/// force.
class QuantizedCoordinate {
 public:
  explicit QuantizedCoordinate(double resolution) : _resolution(resolution) {}
  /// @return the estimate at the time of the sample
  double next(double time, double period, double measured);

 private:
  double _resolution;
  double _measured = 0, _edge = 0;          ///< last value, and the boundary to the value before
  double _direction = 0;                    ///< of the last change
  double _changed_at = 0, _step_time = -1;  ///< time of the last change; duration of a step, < 0: not known
  bool _started = false;
};

class Observer {
 public:
  /// @param device_damping  certain damping of the device [Ns/m]
  /// @param resolution      step of the positions [m]
  Observer(double period, double device_damping, double resolution)
      : _period(period),
        _damping(device_damping),
        _resolution(resolution),
        _coordinates{QuantizedCoordinate(resolution), QuantizedCoordinate(resolution),
                     QuantizedCoordinate(resolution)} {}

  /// The device holds `force` from time `from` on.
  void hold(double from, Vector force);
  /// Whether a sample of this time is later than the last one by more than rounding. @pre started()
  bool is_newer(double time) const { return time - _samples[0].time > 1e-6 * _period; }
  /// @return whether the sample is newer than the last one; others are ignored
  bool sample(double time, Vector measured);
  /// Sets the sums to zero.
  void restart();

  bool started() const { return _n_samples > 0; }
  double time() const { return _samples[0].time; }
  Vector position() const { return _samples[0].position; }  ///< estimate
  Vector measured() const { return _measured; }
  /// Mean of up to the last `n` (1 ... 4) intervals between samples [m/s].
  Vector velocity(int n) const;
  /// Energy that the loop will deliver from the time of the newest sample until `until` at a constant velocity [J].
  double pending(Vector velocity, double until) const;

  /// Forces older than this are forgotten.
  double memory_s() const { return (n_stored - 8) * _period; }

  double work = 0;               ///< taken from the device [J]
  double largest_delivered = 0;  ///< largest -work [J]
  /// Bound of the error of `work` by lost samples and by forces that change while the position seems to stand [J].
  double work_error = 0;
  double dissipated = 0;  ///< by the damping of the device, at least [J]

 private:
  struct Sample {
    double time = 0;
    Vector position = {};
  };
  struct Held {
    double from = 0;
    Vector force = {};
  };
  static constexpr int n_stored = 128;

  /// Calls part(held, seconds) for every force that acted between two times.
  template <class Part>
  void each_force(double from, double to, Part part) const {
    for (int i = 0; i < _n_held && to > from; ++i) {
      const Held& held = _held[(_newest - i + n_stored) % n_stored];
      const bool oldest = i + 1 == _n_held;
      if (held.from >= to && !oldest) continue;
      const double begin = held.from > from && !oldest ? held.from : from;
      part(held, to - begin);
      to = begin;
    }
  }

  double _period, _damping, _resolution;
  QuantizedCoordinate _coordinates[3];
  Vector _measured = {};
  Held _held[n_stored];
  int _newest = 0, _n_held = 0;
  Sample _samples[5];  ///< the newest first
  int _n_samples = 0;
  Sample _window;  ///< begin of the interval over which dissipation is measured
};

}  // namespace phynness::loop
