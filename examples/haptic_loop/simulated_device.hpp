// A hand that holds a haptic device, as an engineer's test bench has it: the hand is a spring and a damper towards
// where it wants to be, the device a mass with friction. It measures its position in steps, and what is read is one
// sample old.
#pragma once

#include <string>
#include <vector>

#include "vector3.hpp"

struct DeviceSettings {
  double mass_kg = 0.08, friction_Ns_per_m = 0.05;
  double hand_stiffness_N_per_m = 250, hand_damping_Ns_per_m = 4;
  double resolution_m = 2e-5;  ///< of the position that is read
  double largest_force_N = 8;  ///< of the motors
};

/// Where the hand wants to be, 1000 times a second.
class HandMotion {
 public:
  /// Taps, presses and circles within `reach_m` of rest, for ever.
  explicit HandMotion(double reach_m) : _reach_m(reach_m) {}
  /// Recorded: three numbers a line, x y z in m from where the tool touched; over and over again.
  /// @throws std::runtime_error  with file and line
  static HandMotion recorded(const std::string& file);
  Vector3 at(long cycle) const;

 private:
  double _reach_m = 0;
  std::vector<Vector3> _positions;
};

class SimulatedDevice {
 public:
  SimulatedDevice(const DeviceSettings& settings, HandMotion motion)
      : _settings(settings), _motion(std::move(motion)) {}

  struct Sample {
    Vector3 position;  ///< m from where the tool touched
    long cycle = 0;    ///< when it was taken
  };
  /// As the driver gives it: rounded to the resolution, one sample old; frozen while the device is stalled.
  Sample read() const { return _delayed; }
  /// Holds `force` [N], cut to what the motors can, for a millisecond.
  void hold(Vector3 force, bool stalled);

 private:
  DeviceSettings _settings;
  HandMotion _motion;
  Vector3 _position, _velocity;
  Sample _delayed, _taken;
  long _cycle = 0;
};
