// The C interface of phynness_loop.h.
#include "loop.hpp"

#include <phynness/phynness.h>

#include <cstdint>
#include <new>

using namespace phynness::loop;

namespace {

/// Periods by which a position may seem to come from the future, for rounding.
constexpr double largest_lead = 0.02;

/// A position that a device can have [m]; others are treated like NaN.
bool plausible(Vector p) {
  constexpr double largest = 1e3;
  return std::fabs(p[0]) <= largest && std::fabs(p[1]) <= largest && std::fabs(p[2]) <= largest;
}

/// A time that a clock can have [s]; others are treated like NaN.
bool usable(double time) { return std::fabs(time) <= 1e12; }

bool is_on(const phn_loop& loop) { return loop.state == PHN_LOOP_ON; }

/// Sets the clock. A time that is earlier than the last one trips the loop.
int advance(phn_loop& loop, double now) {
  if (!usable(now) || (loop.has_time && now < loop.now)) {
    trip(loop, PHN_TRIP_CLOCK);
    return usable(now) ? PHN_ERROR_CLOCK : PHN_ERROR_NOT_FINITE;
  }
  loop.now = now;
  loop.has_time = true;
  return PHN_OK;
}

/// Factor of the force, which rises to 1 after the loop is engaged.
double advance_ramp(phn_loop& loop, double duration) {
  const double ramp_s = loop.settings.ramp_s, step = ramp_s > 0 ? duration / ramp_s : 1;
  loop.ramp = std::fmin(1.0, loop.ramp + step);
  return loop.ramp;
}

/// The force of a cycle in which the loop is on.
/// @param duration  since the last force [s]
Vector next_force(phn_loop& loop, const phn_loop_response& response, double duration) {
  const phn_loop_settings& s = loop.settings;
  double stored = 0;
  Vector force = couple(loop, response, loop.now, stored);
  if (s.trip_force_N > 0 && length(force) > s.trip_force_N) trip(loop, PHN_TRIP_FORCE);
  force = limited_length(advance_ramp(loop, duration) * force, s.largest_force_N);
  if (s.largest_slew_N_per_s > 0)
    force = loop.force + limited_length(force - loop.force, s.largest_slew_N_per_s * duration);
  force = limited_length(limit_energy(loop, force, stored, loop.now), s.largest_force_N);
  if (!is_finite(force)) trip(loop, PHN_TRIP_NOT_FINITE);
  return force;
}

bool is_finite(const phn_loop_response& r) {
  bool all = is_finite(vector_at(r.force)) && is_finite(vector_at(r.displacement)) && std::isfinite(r.energy);
  for (int i = 0; i < 9 && r.has_stiffness != 0; ++i) all &= std::isfinite(r.stiffness[i]);
  return all;
}

void check_response(phn_loop& loop, const phn_loop_response& response) {
  if (response.status < 0) {
    trip(loop, PHN_TRIP_BODY);
  } else if (response.in_contact != 0 && !is_finite(response)) {
    trip(loop, PHN_TRIP_NOT_FINITE);
  }
}

int take_sample(phn_loop& loop, Vector position, double time) {
  if (!plausible(position) || !usable(time)) {
    trip(loop, PHN_TRIP_NOT_FINITE);
    return is_finite(position) && std::isfinite(time) ? PHN_OK : PHN_ERROR_NOT_FINITE;
  }
  if (time > loop.now + largest_lead * loop.settings.period_s) {
    trip(loop, PHN_TRIP_CLOCK);
    return PHN_OK;
  }
  time = std::fmin(time, loop.now);
  if (loop.observer.started() && !loop.observer.is_newer(time)) {
    ++loop.late;
    return PHN_OK;
  }
  check_sample(loop, position, time);
  loop.observer.sample(time, position);
  return PHN_OK;
}

}  // namespace

extern "C" {

int phn_loop_size(size_t* bytes) {
  if (bytes == nullptr) return PHN_ERROR_ARGUMENT;
  *bytes = sizeof(phn_loop) + alignof(phn_loop) - 1;
  return PHN_OK;
}

int phn_loop_init(void* memory, size_t bytes, const phn_loop_settings* settings, phn_loop** loop) {
  if (loop == nullptr) return PHN_ERROR_ARGUMENT;
  *loop = nullptr;
  if (memory == nullptr || settings == nullptr) return PHN_ERROR_ARGUMENT;
  const phn_loop_settings copied = *settings;
  const int refused = status_of(copied);
  if (refused != PHN_OK) return refused;
  const std::size_t off = reinterpret_cast<std::uintptr_t>(memory) % alignof(phn_loop);
  const std::size_t skipped = off == 0 ? 0 : alignof(phn_loop) - off;
  if (bytes < sizeof(phn_loop) + alignof(phn_loop) - 1) return PHN_ERROR_BUFFER;
  *loop = new (static_cast<unsigned char*>(memory) + skipped) phn_loop(copied);
  return PHN_OK;
}

int phn_loop_engage(phn_loop* loop) {
  if (loop == nullptr || loop->state == PHN_LOOP_TRIPPED) return PHN_ERROR_ARGUMENT;
  if (loop->state == PHN_LOOP_ON) return PHN_OK;
  loop->observer.restart();
  loop->withheld = 0;
  loop->has_tool = false;
  loop->state = PHN_LOOP_ON;
  return PHN_OK;
}

int phn_loop_read(phn_loop* loop, const double position[3], double measured, double now, double tool[3]) {
  if (tool != nullptr && loop == nullptr) store({}, tool);
  if (loop == nullptr || tool == nullptr) return PHN_ERROR_ARGUMENT;
  int status = advance(*loop, now);
  if (status == PHN_OK) {
    if (position == nullptr)
      ++loop->missing;
    else
      status = take_sample(*loop, vector_at(position), measured);
    loop->age = loop->observer.started() ? now - loop->observer.time() : 0;
    if (is_on(*loop)) check_cycle(*loop, now);
  }
  if (!loop->has_tool && loop->observer.started()) {
    loop->tool = to_body(*loop, predicted(*loop, loop->now));
    loop->has_tool = true;
  }
  store(loop->tool, tool);
  return status;
}

int phn_loop_hold(phn_loop* loop, const phn_loop_response* response, double now, double force[3]) {
  if (force != nullptr && (loop == nullptr || response == nullptr)) store({}, force);
  if (loop == nullptr || response == nullptr || force == nullptr) return PHN_ERROR_ARGUMENT;
  if ((response->reserved[0] | response->reserved[1]) != 0) {
    store({}, force);
    return PHN_ERROR_VERSION;
  }
  const int status = advance(*loop, now);
  const double duration = loop->has_force ? loop->now - loop->last_force_time : loop->settings.period_s;
  const double overrun = loop->settings.trip_overrun_s;
  if (is_on(*loop) && !(duration > 0)) trip(*loop, PHN_TRIP_CLOCK);
  if (is_on(*loop) && overrun > 0 && duration > overrun) trip(*loop, PHN_TRIP_OVERRUN);
  if (is_on(*loop)) check_response(*loop, *response);

  Vector next = {};
  if (is_on(*loop) && loop->observer.started()) next = next_force(*loop, *response, duration);
  if (loop->state == PHN_LOOP_TRIPPED) next = {};
  loop->force = next;
  loop->last_force_time = loop->now;
  loop->has_force = true;
  loop->observer.hold(loop->now, next);
  ++loop->cycles;
  store(next, force);
  return status;
}

int phn_loop_info(const phn_loop* loop, phn_loop_report* report) {
  if (loop == nullptr || report == nullptr) return PHN_ERROR_ARGUMENT;
  const Observer& o = loop->observer;
  *report = {
      loop->state, loop->trip, o.work,       o.largest_delivered, o.work_error,  o.dissipated, length(o.velocity(4)),
      loop->age,   {},         loop->cycles, loop->limited,       loop->missing, loop->late,   {}};
  store(loop->force, report->force_N);
  return PHN_OK;
}

}  // extern "C"
