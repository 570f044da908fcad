// Conditions that switch the force off.
#include "loop.hpp"

namespace phynness::loop {

void trip(phn_loop& loop, int reason) {
  if (loop.state == PHN_LOOP_TRIPPED) return;
  loop.state = PHN_LOOP_TRIPPED;
  loop.trip = reason;
}

void check_sample(phn_loop& loop, Vector position, double time) {
  const phn_loop_settings& s = loop.settings;
  const Observer& before = loop.observer;
  if (!before.started() || !equal(position, before.measured())) {
    loop.stopped_since = time;
    loop.speed_before_stop = before.started() ? length(before.velocity(4)) : 0;
  } else if (s.trip_frozen_s > 0 && time - loop.stopped_since > s.trip_frozen_s && loop.speed_before_stop > 0.02) {
    // A hand that stops from 20 mm/s takes longer than one sample.
    trip(loop, PHN_TRIP_FROZEN);
  }
  if (!before.started()) return;
  const double periods = std::fmax(1.0, (time - before.time()) / s.period_s);
  const double moved = length(position - before.position());
  if (s.trip_jump_m > 0 && moved > s.trip_jump_m * periods) trip(loop, PHN_TRIP_JUMP);
}

void check_cycle(phn_loop& loop, double now) {
  const phn_loop_settings& s = loop.settings;
  const Observer& o = loop.observer;
  if (s.trip_speed_m_per_s > 0 && length(o.velocity(4)) > s.trip_speed_m_per_s) trip(loop, PHN_TRIP_SPEED);
  const double age = o.started() ? now - o.time() : 0;
  if ((s.trip_stale_s > 0 && age > s.trip_stale_s) || age > o.memory_s()) trip(loop, PHN_TRIP_STALE);
  // Forces that act since the newest sample deliver energy, too.
  const double pending = std::fmax(0.0, o.pending(o.velocity(n_velocity), now));
  if (s.trip_energy_J > 0 && available_energy(loop) + o.work_error - pending < s.allowance_J - s.trip_energy_J)
    trip(loop, PHN_TRIP_ENERGY);
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
    "The position did not change any more after the device had moved.",
    "A cycle took longer than trip_overrun_s.",
    "A position or a response of the body was NaN or infinite.",
    "The clock did not advance or was not finite, or a position was measured later than now.",
    "The response of the body was refused.",
};

}  // namespace

extern "C" const char* phn_loop_trip_message(int trip) {
  if (const char* refused = phynness::loop::setting_message(trip); refused != nullptr) return refused;
  const bool known = trip >= 0 && trip < static_cast<int>(sizeof messages / sizeof *messages);
  return known ? messages[trip] : "This is not a reason of a trip.";
}
