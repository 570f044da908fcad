// The state of a loop and the parts of a cycle. The C interface is in loop.cpp.
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

/// An estimate of the body's tangent stiffness along the motion of the tool, from the last two responses, after a step
/// that overshot: against one of several near tools the body is stiffer than its force over its displacement.
struct TangentEstimate {
  Vector force = {}, displacement = {};  ///< of the last response
  bool has_last = false;
  double stiffness = 0;  ///< [N/m]; decays to 0 when steps no longer overshoot
  /// @param coupling, secant  stiffnesses with which the last step was made [N/m]
  /// @param unbalanced        force that moves the tool next [N]
  void update(Vector force, Vector displacement, double period, double coupling, double secant, Vector unbalanced);
};

}  // namespace phynness::loop

struct phn_loop {
  using Vector = phynness::loop::Vector;

  explicit phn_loop(const phn_loop_settings& s)
      : settings(s), observer(s.period_s, s.device_damping_Ns_per_m, s.position_resolution_m) {}

  phn_loop_settings settings;
  phynness::loop::Observer observer;
  int state = PHN_LOOP_OFF, trip = PHN_TRIP_NONE;

  double now = 0;              ///< of the last call
  double last_force_time = 0;  ///< time of the last phn_loop_hold
  bool has_time = false, has_force = false;
  double ramp = 0;               ///< factor of the force, 0 ... 1
  double age = 0;                ///< of the newest sample at the last phn_loop_read
  double stopped_since = 0;      ///< time since which the position is the same, bit for bit
  double speed_before_stop = 0;  ///< speed before [m/s]

  Vector tool = {};  ///< body frame
  bool has_tool = false;
  phynness::loop::ToolPath path;
  phynness::loop::TangentEstimate tangent;
  Vector force = {};    ///< for the device, as held
  double share = 1;     ///< factor of the passivity controller
  Vector change = {};   ///< of the force by the passivity controller in the last cycle
  double withheld = 0;  ///< observed energy that must not be returned [J]

  std::int64_t cycles = 0, limited = 0, missing = 0, late = 0;
};

namespace phynness::loop {

/// Checks the settings. @return PHN_OK or an error
int status_of(const phn_loop_settings& settings);
/// The range of the setting that this status names; null: it names none.
const char* setting_message(int status);

// Frames.
Vector to_body(const phn_loop& loop, Vector device);         ///< positions
Vector vector_to_device(const phn_loop& loop, Vector body);  ///< displacements [m of the device]
Vector force_to_device(const phn_loop& loop, Vector body);   ///< forces

/// Position of the device in the middle of the interval in which the next force acts, with constant velocity.
Vector predicted(const phn_loop& loop, double now);

/// Moves the tool. @param stored  output: energy of coupling and body at the device [J]. @return force of the coupling
Vector couple(phn_loop& loop, const phn_loop_response& response, double now, double& stored);

/// Limits a force so that the loop stays passive. @param stored  energy of coupling and body [J]
Vector limit_energy(phn_loop& loop, Vector force, double stored, double now);
/// Energy that the loop may deliver now [J].
double available_energy(const phn_loop& loop);

/// Switches to PHN_LOOP_TRIPPED for this reason; the first reason remains.
void trip(phn_loop& loop, int reason);
void check_sample(phn_loop& loop, Vector position, double time);
void check_cycle(phn_loop& loop, double now);

}  // namespace phynness::loop
