// Conditions that switch the force off.
#include "loop.hpp"

namespace phynness::loop {

void trip(phn_loop& loop, int reason, double now) {
  if (loop.state == PHN_LOOP_TRIPPED) return;
  loop.state = PHN_LOOP_TRIPPED;
  loop.trip = reason;
  loop.ramp_from = now;
}

void check_sample(phn_loop& loop, const phn_loop_sample& sample, double time) {
  const phn_loop_settings& s = loop.settings;
  const Observer& before = loop.observer;
  const Vector position = load(sample.position_m);
  if (!before.started() || !equal(position, before.measured())) {
    loop.stopped = time;
    loop.stopped_from = before.started() ? length(before.velocity(4)) : 0;
  } else if (s.trip_frozen_s > 0 && time - loop.stopped > s.trip_frozen_s && loop.stopped_from > 0.02) {
    // A hand that stops from 20 mm/s takes longer than one sample.
    trip(loop, PHN_TRIP_FROZEN, loop.now);
  }
  if (!before.started()) return;
  constexpr double remembered_s = 0.1;
  loop.recent_speed *= std::fmax(0.0, 1 - (time - before.time()) / remembered_s);
  loop.recent_speed = std::fmax(loop.recent_speed, length(before.velocity(4)));
  const double periods = std::fmax(1.0, (time - before.time()) / s.period_s);
  const double moved = length(position - before.position());
  if (s.trip_jump_m > 0 && moved > s.trip_jump_m * periods) trip(loop, PHN_TRIP_JUMP, loop.now);
}

double frozen_share(phn_loop& loop, double now) {
  constexpr double least_N = 0.1, trips_N = 1, at_stake_J = 1e-4, recovery_s = 0.05;
  const phn_loop_settings& s = loop.settings;
  if (!(s.trip_frozen_s > 0)) return 1;
  const double size = length(loop.force), time = loop.observer.time();
  if (loop.unfrozen >= 1) {
    if (size <= least_N) loop.felt = time;
    // The device may go on as fast as before, and takes energy from the loop.
    const double power = size * loop.recent_speed, energy = std::fmax(0.0, budget(loop)) + at_stake_J;
    loop.patience = power * s.trip_frozen_s > energy ? energy / power : s.trip_frozen_s;
    loop.before_fade = size;
  }
  const double since = time - std::fmax(loop.stopped, loop.felt) - loop.patience;
  if (since <= 0) return loop.unfrozen = std::fmin(1.0, loop.unfrozen + s.period_s / recovery_s);
  // A heavy device, too, is to move by some steps while the force fades as 1 - (t / d)^3: by f d^2 / (20 m) at its end.
  const double heavy = 10 * s.least_mass_kg * s.position_resolution_m;
  const double duration = std::fmax(2 * loop.patience, std::sqrt(80 * heavy / loop.before_fade));
  const double part = since / duration;
  loop.unfrozen = std::fmin(loop.unfrozen, std::fmax(0.0, 1 - part * part * part));
  // Friction can hold a device against a small change of the force, and a hand can rest.
  if (loop.unfrozen <= 0 && loop.before_fade > trips_N) trip(loop, PHN_TRIP_FROZEN, now);
  return loop.unfrozen;
}

void check_cycle(phn_loop& loop, double now) {
  const phn_loop_settings& s = loop.settings;
  const Observer& o = loop.observer;
  if (s.trip_speed_m_per_s > 0 && length(o.velocity(4)) > s.trip_speed_m_per_s) trip(loop, PHN_TRIP_SPEED, now);
  if (s.trip_stale_s > 0 && o.started() && now - o.time() - s.latency_s > s.trip_stale_s)
    trip(loop, PHN_TRIP_STALE, now);
  if (o.started() && now + s.force_delay_s - o.time() > o.memory_s()) trip(loop, PHN_TRIP_STALE, now);
  // Forces that act since the newest sample deliver energy, too.
  const double unseen = std::fmax(0.0, o.pending(o.velocity(n_velocity), now + s.force_delay_s));
  if (s.trip_energy_J > 0 && loop.state != PHN_LOOP_CHECKING &&
      budget(loop) + o.unsure - unseen < s.allowance_J - s.trip_energy_J)
    trip(loop, PHN_TRIP_ENERGY, now);
  // Test pulses deliver energy to every device. What the motors do beyond the pulses does not.
  if (s.trip_energy_J > 0 && loop.state == PHN_LOOP_CHECKING && o.excess > s.trip_energy_J)
    trip(loop, PHN_TRIP_ENERGY, now);
}

}  // namespace phynness::loop

namespace {

/// In the order of the reasons.
const char* const messages[] = {
    "The loop has not tripped.",
    "The loop delivered more energy than it took from the device and the device dissipated.",
    "The force of the coupling was larger than trip_force_N.",
    "The device moved faster than trip_speed_m_per_s.",
    "The position of the device jumped by more than trip_jump_m.",
    "No new position arrived for trip_stale_s.",
    "The position did not change any more after the device had moved, or while a force faded to zero.",
    "A cycle took longer than trip_overrun_s.",
    "A position or a response of the body was NaN or infinite.",
    "The clock ran backwards, stood still or was not finite, or a position was younger than latency_s.",
    "The device did not move along the test pulses: it is blocked, gripped too firmly or moved too much (hold "
    "it loosely and still, and engage again), or an axis, a sign or a unit of its positions or forces is "
    "wrong.",
    "The response of the body was refused.",
};

}  // namespace

extern "C" const char* phn_loop_trip_message(int trip) {
  const bool known = trip >= 0 && trip < static_cast<int>(sizeof messages / sizeof *messages);
  return known ? messages[trip] : "This is not a reason of a trip.";
}
