// A hand that holds a haptic device. The hand is a spring and a damper to its intended position; the device is a mass
// with friction. Positions are quantized and one sample old.
#pragma once

#include <string>
#include <vector>

#include "vector3.hpp"

struct DeviceSettings {
  double mass_kg = 0.08, friction_Ns_per_m = 0.05;
  double hand_stiffness_N_per_m = 250, hand_damping_Ns_per_m = 4;
  double resolution_m = 2e-5;  ///< of the measured position
  double largest_force_N = 8;  ///< of the motors
};

/// Intended position of the hand, 1000 times per second.
class HandMotion {
 public:
  /// Endless taps, presses and circles within `reach_m` of rest.
  explicit HandMotion(double reach_m) : _reach_m(reach_m) {}
  /// A recording with three numbers per line, x y z in m relative to the first contact, which is repeated.
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
    Vector3 position;  ///< [m], relative to the first contact
    long cycle = 0;    ///< of the measurement
  };
  /// The position as a driver gives it: rounded to the resolution and one sample old; frozen while the device is
  /// stalled.
  Sample read() const { return _delayed; }
  /// Applies `force` [N], limited by the motors, for a millisecond.
  void hold(Vector3 force, bool stalled);

 private:
  DeviceSettings _settings;
  HandMotion _motion;
  Vector3 _position, _velocity;
  Sample _delayed, _taken;
  long _cycle = 0;
};
