// The state of a loop and the steps of a cycle: settings.cpp, coupling.cpp, controller.cpp,
// trips.cpp; loop.cpp is the C interface.
#pragma once

#include <phynness/phynness_loop.h>

#include <cstdint>

#include "observer.hpp"

namespace phynness::loop {

/// Velocities are means over this many samples.
inline constexpr int n_velocity = 3;

/// Position of the tool in the last cycles, in the frame of the device, for its velocity.
struct ToolPath {
  Vector last[n_velocity + 1] = {};
  int n = 0;
  void add(Vector tool);
  Vector velocity(double period) const;
};

}  // namespace phynness::loop

struct phn_loop {
  using Vector = phynness::loop::Vector;

  explicit phn_loop(const phn_loop_settings& s)
      : settings(s), observer(s.period_s, s.device_damping_Ns_per_m, s.position_resolution_m) {}

  phn_loop_settings settings;
  phynness::loop::Observer observer;
  int state = PHN_LOOP_OFF, trip = PHN_TRIP_NONE;

  double now = 0;        ///< of the last call
  double last_hold = 0;  ///< time of the last phn_loop_hold
  bool has_time = false, has_held = false;
  double ramp = 0;          ///< factor of the force, 0 ... 1
  double age = 0;           ///< of the newest sample at the last phn_loop_read
  double stopped = 0;       ///< time since which the position is the same, bit for bit
  double stopped_from = 0;  ///< speed before [m/s]

  Vector tool = {};     ///< body frame
  bool placed = false;  ///< `tool` has been set
  phynness::loop::ToolPath path;
  Vector force = {};     ///< for the device, as held
  double share = 1;      ///< factor of the passivity controller
  Vector change = {};    ///< of the force by the passivity controller in the last cycle
  double forgotten = 0;  ///< observed energy that must not be returned [J]

  std::int64_t cycles = 0, limited = 0, missing = 0, late = 0;
};

namespace phynness::loop {

/// PHN_OK, or why these settings are refused.
int status_of(const phn_loop_settings& settings);

// Frames.
Vector to_body(const phn_loop& loop, Vector device);         ///< positions
Vector vector_to_device(const phn_loop& loop, Vector body);  ///< displacements [m of the device]
Vector force_to_device(const phn_loop& loop, Vector body);   ///< forces

/// Position of the device in the middle of the interval in which the next force acts, with constant velocity.
Vector predicted(const phn_loop& loop, double now);

/// Moves the tool; gives the force of the coupling and, in `stored`, the energy of coupling and body, at the device.
Vector couple(phn_loop& loop, const phn_loop_response& response, double now, double& stored);

/// The force that keeps the loop passive. @param stored  energy of coupling and body [J]
Vector kept_passive(phn_loop& loop, Vector force, double stored, double now);
/// Energy that the loop may deliver now [J].
double budget(const phn_loop& loop);

/// Switches to PHN_LOOP_TRIPPED for this reason; the first reason remains.
void trip(phn_loop& loop, int reason);
void check_sample(phn_loop& loop, Vector position, double time);
void check_cycle(phn_loop& loop, double now);

}  // namespace phynness::loop
