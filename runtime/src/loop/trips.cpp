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
  if (!before.started() || !equal(position, before.position())) {
    loop.stopped = time;
    loop.stopped_from = before.started() ? length(before.velocity(4)) : 0;
  } else if (s.trip_frozen_s > 0 && time - loop.stopped > s.trip_frozen_s && loop.stopped_from > 0.02) {
    // A hand that stops from 20 mm/s takes longer than one sample.
    trip(loop, PHN_TRIP_FROZEN, loop.now);
  }
  if (!before.started()) return;
  const double periods = std::fmax(1.0, (time - before.time()) / s.period_s);
  const double moved = length(position - before.position());
  if (s.trip_jump_m > 0 && moved > s.trip_jump_m * periods) trip(loop, PHN_TRIP_JUMP, loop.now);
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
}

}  // namespace phynness::loop
