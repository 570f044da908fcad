// The C interface of phynness_loop.h.
#include "loop.hpp"

#include <phynness/phynness.h>

#include <cstdint>
#include <new>

using namespace phynness::loop;

namespace {

/// Calls of phn_loop_hold at the same time, after which the clock has stopped.
constexpr int most_still = 50;
/// Periods by which a position may seem younger than it can be, for rounding.
constexpr double largest_lead = 0.02;
/// Force that a device can report [N].
constexpr double largest_report = 1e6;

/// A position that a device can have [m]; others are treated like NaN.
bool plausible(const phn_loop_sample& sample) {
  constexpr double largest = 1e3;
  bool all = true;
  for (const double x : sample.position_m) all &= std::fabs(x) <= largest;
  return all;
}

/// A time that a clock can have [s]; others are treated like NaN.
bool usable(double time) { return std::fabs(time) <= 1e12; }

bool is_on(const phn_loop& loop) { return loop.state != PHN_LOOP_OFF && loop.state != PHN_LOOP_TRIPPED; }

/// Factor of the force; ends ramps.
double advance_ramp(phn_loop& loop, double now) {
  const phn_loop_settings& s = loop.settings;
  const double since = now - loop.ramp_from;
  const auto share = [&](double duration) { return duration > 0 ? std::fmin(1.0, since / duration) : 1; };
  switch (loop.state) {
    case PHN_LOOP_ENGAGING:
      loop.ramp = std::fmax(loop.ramp, share(s.engage_s));
      if (loop.ramp >= 1) loop.state = PHN_LOOP_ON;
      break;
    case PHN_LOOP_ON:
      loop.ramp = 1;
      break;
    case PHN_LOOP_RELEASING:
    case PHN_LOOP_CLUTCHED:
      loop.ramp = std::fmin(loop.ramp, 1 - share(s.release_s));
      if (loop.state == PHN_LOOP_RELEASING && loop.ramp <= 0) loop.state = PHN_LOOP_OFF;
      break;
    default:
      loop.ramp = 0;
  }
  return loop.ramp;
}

/// The last force, lowered to zero within trip_ramp_s. A part that would help the motion ends at once, and so does the
/// whole force after PHN_TRIP_ENERGY and PHN_TRIP_CHECK, where what acts is not the force of this loop, and after
/// PHN_TRIP_CLOCK, where no ramp has an end.
Vector ramped_down(const phn_loop& loop, double now) {
  const double ramp = loop.settings.trip_ramp_s, dt = now - loop.last_hold, left = loop.ramp_from + ramp - now;
  if (!(left > 0) || loop.trip == PHN_TRIP_ENERGY || loop.trip == PHN_TRIP_CHECK || loop.trip == PHN_TRIP_CLOCK)
    return {};
  Vector force = (left / (left + std::fmax(0.0, dt))) * loop.force;
  const Vector velocity = loop.observer.velocity(n_velocity);
  const double power = dot(force, velocity), speed2 = dot(velocity, velocity);
  if (power > 0) force = force - (power / speed2) * velocity;
  return finite(force) ? force : Vector{};
}

Vector rounded(Vector force, double step) {
  if (!(step > 0)) return force;
  // Towards zero, so that the force stays within its limit.
  return {step * std::trunc(force.x / step), step * std::trunc(force.y / step), step * std::trunc(force.z / step)};
}

/// The force of a cycle in which the loop is on.
Vector next_force(phn_loop& loop, const phn_loop_response& response, double now) {
  const phn_loop_settings& s = loop.settings;
  double stored = 0;
  Vector force = couple(loop, response, now, stored);
  if (!finite(force)) {
    trip(loop, PHN_TRIP_NOT_FINITE, now);
    return {};
  }
  if (s.trip_force_N > 0 && length(force) > s.trip_force_N) trip(loop, PHN_TRIP_FORCE, now);
  force = frozen_share(loop, now) * shortened(advance_ramp(loop, now) * force, s.largest_force_N);
  if (s.largest_slew_N_per_s > 0)
    force = loop.force + shortened(force - loop.force, s.largest_slew_N_per_s * std::fmax(0.0, now - loop.last_hold));
  return rounded(shortened(kept_passive(loop, force, stored, now), s.largest_force_N), s.force_resolution_N);
}

/// Test pulses: @return whether the check goes on.
bool check_device(phn_loop& loop, double now, Vector& force) {
  force = loop.check.next(now + loop.settings.force_delay_s);
  if (!loop.check.finished()) return true;
  if (!loop.check.passed()) {
    trip(loop, PHN_TRIP_CHECK, now);
  } else {
    loop.state = PHN_LOOP_ENGAGING;
    loop.ramp_from = now;
    loop.ramp = 0;
    loop.observer.restart();
    loop.forgotten = 0;
    // The pulses ended the motion of a device that nobody holds.
    loop.stopped_from = 0;
  }
  return false;
}

bool is_finite(const phn_loop_response& r) {
  bool all = finite(load(r.force)) && finite(load(r.displacement)) && std::isfinite(r.energy);
  for (int i = 0; i < 9 && r.has_stiffness != 0; ++i) all &= std::isfinite(r.stiffness[i]);
  return all;
}

void check_response(phn_loop& loop, const phn_loop_response& response, double now) {
  if (response.status < 0) {
    trip(loop, PHN_TRIP_BODY, now);
  } else if (response.in_contact != 0 && !is_finite(response)) {
    trip(loop, PHN_TRIP_NOT_FINITE, now);
  }
}

void take_sample(phn_loop& loop, const phn_loop_sample* sample) {
  if (sample == nullptr) {
    ++loop.missing;
    return;
  }
  const phn_loop_settings& s = loop.settings;
  double time = s.has_times != 0 ? sample->time_s : loop.now - s.latency_s;
  if (!plausible(*sample) || !usable(time)) {
    trip(loop, PHN_TRIP_NOT_FINITE, loop.now);
    return;
  }
  // No position comes from the future, or arrives sooner than it can.
  if (time > loop.now - s.latency_s + largest_lead * s.period_s) {
    trip(loop, PHN_TRIP_CLOCK, loop.now);
    return;
  }
  time = std::fmin(time, loop.now);
  if (loop.observer.started() && !loop.observer.is_newer(time)) {
    ++(time < loop.observer.time() ? loop.reordered : loop.repeated);
    return;
  }
  check_sample(loop, *sample, time);
  loop.observer.sample(time, load(sample->position_m));
  if (loop.state == PHN_LOOP_CHECKING) loop.check.sample(time, load(sample->position_m));
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
  if (bytes < sizeof(phn_loop) + skipped) return PHN_ERROR_BUFFER;
  *loop = new (static_cast<unsigned char*>(memory) + skipped) phn_loop(copied);
  return PHN_OK;
}

int phn_loop_engage(phn_loop* loop) {
  if (loop == nullptr || loop->state == PHN_LOOP_TRIPPED) return PHN_ERROR_ARGUMENT;
  if (loop->state != PHN_LOOP_OFF && loop->state != PHN_LOOP_RELEASING) return PHN_OK;
  loop->ramp_from = loop->now;
  loop->observer.restart();
  loop->forgotten = 0;
  if (loop->state == PHN_LOOP_OFF) {
    loop->placed = false;
    loop->ramp = 0;
  }
  if (loop->settings.check_force_N > 0 && loop->state == PHN_LOOP_OFF) {
    loop->state = PHN_LOOP_CHECKING;
    loop->check.restart();
  } else {
    loop->state = PHN_LOOP_ENGAGING;
  }
  return PHN_OK;
}

int phn_loop_release(phn_loop* loop) {
  if (loop == nullptr || loop->state == PHN_LOOP_TRIPPED) return PHN_ERROR_ARGUMENT;
  if (loop->state == PHN_LOOP_OFF || loop->state == PHN_LOOP_RELEASING) return PHN_OK;
  loop->state = loop->state == PHN_LOOP_CHECKING ? PHN_LOOP_OFF : PHN_LOOP_RELEASING;
  loop->ramp_from = loop->now;
  return PHN_OK;
}

int phn_loop_clutch(phn_loop* loop, int32_t on) {
  if (loop == nullptr) return PHN_ERROR_ARGUMENT;
  const bool clutched = loop->state == PHN_LOOP_CLUTCHED;
  if (!clutched && loop->state != PHN_LOOP_ENGAGING && loop->state != PHN_LOOP_ON) return PHN_ERROR_ARGUMENT;
  if (clutched == (on != 0)) return PHN_OK;
  const Vector place = to_body(*loop, loop->observer.position());
  if (on != 0) {
    loop->clutch_at = place;
    loop->state = PHN_LOOP_CLUTCHED;
  } else {
    const Vector moved = loop->clutch_at - place;
    loop->origin[0] += moved.x;
    loop->origin[1] += moved.y;
    loop->origin[2] += moved.z;
    loop->state = PHN_LOOP_ENGAGING;
    loop->path.n = 0;
  }
  loop->ramp_from = loop->now;
  return PHN_OK;
}

int phn_loop_reset(phn_loop* loop) {
  if (loop == nullptr) return PHN_ERROR_ARGUMENT;
  const phn_loop_settings settings = loop->settings;
  *loop = phn_loop(settings);
  return PHN_OK;
}

int phn_loop_read(phn_loop* loop, const phn_loop_sample* sample, double now, double tool[3]) {
  if (tool != nullptr && loop == nullptr) store({}, tool);
  if (loop == nullptr || tool == nullptr) return PHN_ERROR_ARGUMENT;
  int status = PHN_OK;
  if (!usable(now) || (loop->has_time && now < loop->now)) {
    trip(*loop, PHN_TRIP_CLOCK, loop->now);
    status = usable(now) ? PHN_ERROR_CLOCK : PHN_ERROR_NOT_FINITE;
  } else {
    loop->now = now;
    loop->has_time = true;
    if (sample != nullptr &&
        !(finite(load(sample->position_m)) && (loop->settings.has_times == 0 || std::isfinite(sample->time_s))))
      status = PHN_ERROR_NOT_FINITE;
    take_sample(*loop, sample);
    loop->latency = loop->observer.started() ? now - loop->observer.time() : 0;
    if (is_on(*loop)) check_cycle(*loop, now);
  }
  if (!loop->placed && loop->observer.started()) {
    loop->tool = to_body(*loop, predicted(*loop, loop->now));
    loop->placed = true;
  }
  store(loop->tool, tool);
  return status;
}

int phn_loop_hold(phn_loop* loop, const phn_loop_response* response, double now, double force[3]) {
  if (force != nullptr && (loop == nullptr || response == nullptr)) store({}, force);
  if (loop == nullptr || response == nullptr || force == nullptr) return PHN_ERROR_ARGUMENT;
  int status = PHN_OK;
  if (!usable(now) || now < loop->now) {
    trip(*loop, PHN_TRIP_CLOCK, loop->now);
    status = usable(now) ? PHN_ERROR_CLOCK : PHN_ERROR_NOT_FINITE;
    now = loop->now;
  }
  loop->now = now;
  loop->has_time = true;
  const double overrun = loop->settings.trip_overrun_s;
  if (is_on(*loop) && loop->has_held && overrun > 0 && now - loop->last_hold > overrun)
    trip(*loop, PHN_TRIP_OVERRUN, now);
  loop->still = loop->has_held && now == loop->last_hold ? loop->still + 1 : 0;
  if (is_on(*loop) && loop->still > most_still) trip(*loop, PHN_TRIP_CLOCK, now);
  if (is_on(*loop) && loop->state != PHN_LOOP_CHECKING) check_response(*loop, *response, now);

  Vector next;
  if (loop->state == PHN_LOOP_CHECKING && loop->observer.started())
    check_device(*loop, now, next);
  else if (is_on(*loop) && loop->state != PHN_LOOP_CHECKING && loop->observer.started())
    next = loop->state == PHN_LOOP_CLUTCHED && loop->ramp <= 0 ? Vector{} : next_force(*loop, *response, now);
  if (!finite(next)) {
    trip(*loop, PHN_TRIP_NOT_FINITE, now);
    loop->force = next = {};
  }
  if (loop->state == PHN_LOOP_TRIPPED) next = ramped_down(*loop, now);
  loop->force = next;
  loop->last_hold = now;
  loop->has_held = true;
  loop->observer.hold(now + loop->settings.force_delay_s, next);
  ++loop->cycles;
  store(next, force);
  return status;
}

int phn_loop_held(phn_loop* loop, const double force[3]) {
  if (loop == nullptr || force == nullptr || !loop->has_held) return PHN_ERROR_ARGUMENT;
  if (!(length(load(force)) <= largest_report)) {
    trip(*loop, PHN_TRIP_NOT_FINITE, loop->now);
    return PHN_ERROR_NOT_FINITE;
  }
  loop->observer.correct(load(force));
  // Motors that apply more than a test pulse are not those that were commanded.
  const phn_loop_settings& s = loop->settings;
  if (loop->state == PHN_LOOP_CHECKING && length(load(force)) > 2 * s.check_force_N + s.force_resolution_N)
    trip(*loop, PHN_TRIP_CHECK, loop->now);
  return PHN_OK;
}

int phn_loop_get_report(const phn_loop* loop, phn_loop_report* report) {
  if (loop == nullptr || report == nullptr) return PHN_ERROR_ARGUMENT;
  const Observer& o = loop->observer;
  *report = {
      loop->state,           loop->trip,    o.work, o.most_delivered, o.gross,       o.unsure,      o.dissipated,
      length(o.velocity(4)), loop->latency, {},     loop->cycles,     loop->limited, loop->missing, loop->repeated,
      loop->reordered};
  store(loop->force, report->force_N);
  return PHN_OK;
}

}  // extern "C"
