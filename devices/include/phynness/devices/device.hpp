// One interface for haptic devices: open, read with a time, hold a force, close. docs/howto/haptic-loop.md shows how to
// write an adapter for the library of a manufacturer.
#pragma once

#include <phynness/phynness_loop.h>

#include <string>

namespace phynness::devices {

/// Properties of a device that a controller needs; entries of phn_loop_settings have the same names.
struct Traits {
  std::string name;
  double period_s = 1e-3;            ///< between positions
  bool has_times = false;            ///< read() gives the time of the measurement
  double latency_s = 0;              ///< otherwise the age of a position when it is read
  double force_delay_s = 0;          ///< delay between hold() and its effect
  double position_resolution_m = 0;  ///< step of the positions
  double damping_Ns_per_m = 0;       ///< guaranteed physical damping
  double largest_force_N = 0;        ///< continuous force of the motors
  double force_resolution_N = 0;     ///< step of the forces of the motors
};

/// A device that translates. Position and force have the axes of the device.
class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  /// @throws std::runtime_error  with the reason and the remedy
  virtual void open() = 0;
  /// Valid after open().
  virtual Traits traits() const = 0;
  /// Time of the clock of the device [s], which never decreases; samples have times of this clock.
  virtual double now() = 0;
  /// Waits for the beginning of the next cycle. @return false if there are no more positions
  virtual bool wait() = 0;
  /// The newest position. Does not block. @return false if none arrived since the last call
  virtual bool read(phn_loop_sample& sample) = 0;
  /// Applies the force [N] until the next call.
  virtual void hold(const double force[3]) = 0;
  /// The force [N] that the motors apply. @return false if the device does not measure it
  virtual bool held(double force[3]) {
    static_cast<void>(force);
    return false;
  }
  /// Switches the force off. May be called several times.
  virtual void close() noexcept = 0;
};

/// The defaults of the loop with the traits of a device.
phn_loop_settings settings_for(const Traits& traits);

}  // namespace phynness::devices
