// The state of a loop and the steps of a cycle: settings.cpp, coupling.cpp, controller.cpp,
// trips.cpp; loop.cpp is the C interface.
#pragma once

#include <phynness/phynness_loop.h>

#include <cstdint>

#include "device_check.hpp"
#include "observer.hpp"

namespace phynness::loop {

/// Velocities are means over this many samples.
inline constexpr int n_velocity = 3;

/// Position of the tool in the last cycles, in the frame of the device, for its velocity.
struct ToolPath {
  Vector last[n_velocity + 1];
  int n = 0;
  void add(Vector tool);
  Vector velocity(double period) const;
};

}  // namespace phynness::loop

struct phn_loop {
  using Vector = phynness::loop::Vector;

  explicit phn_loop(const phn_loop_settings& s)
      : settings(s),
        observer(s.period_s, s.device_damping_Ns_per_m, s.position_resolution_m),
        check(s.check_force_N, s.period_s) {
    for (int k = 0; k < 3; ++k) origin[k] = s.origin_m[k];
  }

  phn_loop_settings settings;
  phynness::loop::Observer observer;
  phynness::loop::DeviceCheck check;
  int state = PHN_LOOP_OFF, trip = PHN_TRIP_NONE;
  double origin[3] = {};

  int still = 0;         ///< calls of phn_loop_hold since the clock advanced
  double now = 0;        ///< of the last call
  double last_hold = 0;  ///< time of the last phn_loop_hold
  bool has_time = false, has_held = false;
  double ramp_from = 0;     ///< time at which the present ramp began
  double ramp = 0;          ///< factor of the force, 0 ... 1
  double latency = 0;       ///< age of the newest sample at the last phn_loop_read
  double stopped = 0;       ///< time since which the position is the same, bit for bit
  double stopped_from = 0;  ///< speed before [m/s]
  double felt = 0;          ///< time of the last sample without a force that can be felt
  double unfrozen = 1;      ///< factor of the force, which fades while the position is the same
  double before_fade = 0;   ///< size of the force before it faded [N]
  double patience = 0;      ///< time without a change of the position until the force fades [s]
  double recent_speed = 0;  ///< largest speed of the last tenth of a second [m/s]

  Vector tool;          ///< body frame
  bool placed = false;  ///< `tool` has been set
  Vector clutch_at;     ///< body position of the device when the clutch was switched on
  phynness::loop::ToolPath path;
  Vector force;          ///< for the device, as held
  double share = 1;      ///< factor of the passivity controller
  Vector change;         ///< of the force by the passivity controller in the last cycle
  double forgotten = 0;  ///< observed energy that must not be returned [J]

  std::int64_t cycles = 0, limited = 0, missing = 0, repeated = 0, reordered = 0;
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
void trip(phn_loop& loop, int reason, double now);
void check_sample(phn_loop& loop, const phn_loop_sample& sample, double time);
void check_cycle(phn_loop& loop, double now);
/// Factor of the force: it fades while a force is held and no position changes. A position that can still be measured
/// changes when the force does, long before it is zero.
double frozen_share(phn_loop& loop, double now);

}  // namespace phynness::loop
