// Haply's Inverse3 behind the interface of a device, by way of Haply's Inverse service: a program of Haply that runs on
// the same computer and speaks JSON over a WebSocket. Written after Haply's public documentation and tested against a
// server of the tests; no hardware was touched.
//
// Implemented is the simulation channel of the 3.x format on port 10001, as documented for service 3.5:
//   https://docs.haply.co/inverseSDK/service/realtime/websocket-protocol   one state update for each message
//   https://docs.haply.co/inverseSDK/service/realtime/control-commands     set_cursor_force, newtons
//   https://docs.haply.co/inverseSDK/service/commons/json-conventions      names of devices, config, state and status
//   https://docs.haply.co/inverseSDK/service/commons/basis                 right-handed; x right, y forward, z up
// The format 3.0 on port 10000, which the service drops in version 4, is not implemented.
#pragma once

#include <phynness/devices/device.hpp>

#include <cstdint>
#include <memory>

namespace phynness::devices {

struct HaplyInverseSettings {
  std::string host = "localhost";
  std::uint16_t port = 10001;
  std::string device_id;  ///< empty: the only Inverse3 of the service
  /// Name of the vector in set_cursor_force: "vector" in the pages of service 3.5, "values" in programs for
  /// earlier 3.x. The service ignores names that it does not know, so that the wrong one gives no force;
  /// phn_loop_engage finds this.
  std::string force_name = "vector";
  std::string profile = "phynness";  ///< name of this program in Haply Hub
  double period_s = 1e-3;
  double timeout_s = 1;          ///< for the connection, each answer, and the end of the connection
  double hold_timeout_s = 0.05;  ///< without hold() for so long, the force becomes zero
  /// Without a valid answer to a message for so long, the force becomes zero, and stays zero until one arrives.
  double answer_timeout_s = 0.01;
  double largest_force_N = 2;  ///< a longer force is shortened
  /// Messages have no times. The time of a sample is that of its arrival minus this.
  double position_age_s = 0;
  double force_delay_s = 0;          ///< as Traits
  double position_resolution_m = 0;  ///< as Traits
};

/// Messages since open().
struct HaplyInverseCounts {
  long sent = 0;       ///< to the service
  long answers = 0;    ///< state updates with a position
  long malformed = 0;  ///< answers that were not used
  long unasked = 0;    ///< messages of the service that no message of ours asked for; not used
  long silenced = 0;   ///< times that the force became zero because hold() was not called or answers did not come
};

/// A thread of its own reads and writes the socket. Positions get their time when they arrive there. All functions
/// except counts() and lost() belong to one thread.
class HaplyInverse : public Device {
 public:
  explicit HaplyInverse(HaplyInverseSettings settings);
  /// As close().
  ~HaplyInverse() override;

  /// Connects, selects the device, and waits for a first position.
  /// @throws std::runtime_error  with what, the value and the remedy: a setting out of its range, no service, no
  /// answer, an
  ///                             answer that is not as documented, no device or several, a device that is not ready, or
  ///                             a transform with a scale, with which force times motion is not work
  void open() override;
  Traits traits() const override;
  double now() override;
  /// Returns at multiples of the period. @return false if the connection is lost
  bool wait() override;
  bool read(phn_loop_sample& sample) override;
  /// Sends the force. Does not wait for the service. While several messages have no answer, the newest force waits for
  /// one, but zero is sent at once. A force that is not finite is sent as zero.
  void hold(const double force[3]) override;
  /// The force of the last hold(), shortened to the largest force, or what the service reports if that is none of the
  /// last sixteen forces (within 1 mN and 1 %) and not exactly zero, which a service reports that does not know it.
  bool held(double force[3]) override;
  /// Sends zero force, whether or not the service answers, and closes the connection, within timeout_s.
  void close() noexcept override;

  /// Why the connection was lost, with value and remedy; empty: it was not.
  std::string lost() const;
  HaplyInverseCounts counts() const;
  /// current_cursor_force of the newest state update [N]. @return false if it had none
  bool reported_force(double force[3]);

 private:
  class Link;
  bool was_commanded(const double (&reported)[3]) const;
  HaplyInverseSettings _settings;
  std::unique_ptr<Link> _link;
  bool _is_open = false;
  double _next = 0;
  static constexpr int n_recent = 16;
  double _held[3] = {};
  double _recent[n_recent][3] = {};  ///< the last forces of hold()
  long _n_holds = 0;
};

}  // namespace phynness::devices
