// Test of a device by small force pulses: along each axis a force +F, -F, -F, +F of eight cycles each, and the mobility
// that the measured positions show. While the hand moves too much for a judgement, the pulses are repeated.
#pragma once

#include "vector.hpp"

namespace phynness::loop {

class DeviceCheck {
 public:
  explicit DeviceCheck(double force) : _force(force) {}

  void restart();
  bool finished() const { return _axis == 3; }
  /// Force for the cycle that begins at `time`, when the device will apply it.
  Vector next(double time);
  /// A position measured at `time`.
  void sample(double time, Vector position);
  /// Whether the device moved along the force on each axis, less than half as much across it, and as a mass of 5 g to
  /// 5 kg would. False, too, if the hand moved too much in every attempt.
  bool passed() const { return _passed; }

 private:
  static constexpr int eighth = 8, most_attempts = 40;
  static constexpr int longest_wait = 40;  ///< cycles, for positions that arrive late

  double response(double time) const;
  bool moved_as_pushed();
  void begin_axis(int axis);

  double _force;
  int _axis = 3, _cycle = 0, _attempts = 0;
  bool _passed = false;
  double _switch[4] = {};  ///< times at which the force of this axis changed
  double _normal[4][4] = {}, _right[4][4] = {}, _squares[3] = {};
  double _first[3] = {};
  int _n_samples = 0;
  double _newest = 0;  ///< time of the last position
};

}  // namespace phynness::loop
