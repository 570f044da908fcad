// Test of a device by small force pulses: along each axis a force +F, -F, -F, +F of 8 ms each, and the mobility
// that the measured positions show. While the hand moves too much for a judgement, the pulses are repeated, and become
// longer.
#pragma once

#include "vector.hpp"

namespace phynness::loop {

class DeviceCheck {
 public:
  DeviceCheck(double force, double period_s) : _force(force), _period(period_s), _longest_wait(cycles(40e-3, 5)) {}

  void restart();
  bool finished() const { return _axis == 3; }
  /// Force for the cycle that begins at `time`, when the device will apply it.
  Vector next(double time);
  /// A position measured at `time`.
  void sample(double time, Vector position);
  /// Whether the device moved along the force on each axis, less than half as much across it, and as a mass of 2 g to
  /// 10 kg would in a hand that is a spring and a damper. False, too, if the hand moved too much in every attempt.
  bool passed() const { return _passed; }

 private:
  static constexpr int most_attempts = 40;
  /// @return the number of cycles in so many seconds, but at least `least`
  int cycles(double seconds, int least) const {
    const double n = seconds / _period + 0.5;
    return n > 1e6 ? 1'000'000 : n > least ? static_cast<int>(n) : least;
  }

  /// Displacement of a mass of 1 kg with damping and stiffness under the pulses, in units of 1e-5 m, and the sums of a
  /// fit of it and of a parabola to the measured positions.
  struct Response {
    double damping = 0, stiffness = 0;  ///< [Ns/m], [N/m]
    double x = 0, v = 0;
    double normal[4][4] = {}, right[4][3] = {};
  };
  static constexpr int n_responses = 16;

  double pulse(double time) const;
  void advance(double time);
  bool moved_as_pushed() const;
  void begin_axis(int axis);

  double _force, _period;
  int _eighth = 0;    ///< cycles of a pulse
  int _longest_wait;  ///< cycles, for positions that arrive late
  int _axis = 3, _cycle = 0, _attempts = 0;
  bool _passed = false;
  double _switch[4] = {};  ///< times at which the force of this axis changed
  Response _responses[n_responses];
  double _at = 0;  ///< time of the responses
  double _squares[3] = {}, _first[3] = {};
  int _n_samples = 0;
  double _newest = 0;  ///< time of the last position
};

}  // namespace phynness::loop
