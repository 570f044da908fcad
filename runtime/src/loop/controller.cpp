// Passivity controller: the loop must not deliver more energy than it took. docs/howto/haptic-loop.md derives it.
#include "loop.hpp"

namespace phynness::loop {

namespace {
constexpr double recovery_s = 0.05;
}

double budget(const phn_loop& loop) {
  const Observer& o = loop.observer;
  return loop.settings.allowance_J + o.work + o.dissipated - o.unsure - loop.forgotten;
}

Vector kept_passive(phn_loop& loop, Vector force, double stored, double now) {
  const phn_loop_settings& s = loop.settings;
  const Vector velocity = loop.observer.velocity(n_velocity);
  const double speed2 = dot(velocity, velocity), power = dot(force, velocity);
  // The effect of this force is observed when the first sample arrives that was measured after it has acted.
  const double acts = now + s.force_delay_s, unseen = std::fmax(0.0, acts - loop.observer.time()) + s.period_s;
  const double pending = loop.observer.pending(velocity, acts);
  // Energy that was dissipated must not be returned later, except for a reserve and what is not observed yet.
  const double kept = stored + s.largest_reserve_J + s.allowance_J + unseen * length(loop.force) * std::sqrt(speed2);
  loop.forgotten += std::fmax(0.0, budget(loop) - pending - kept);
  if (s.passivity_controller == 0) return force;

  const double left = budget(loop) - std::fmax(0.0, pending);
  // A force that resists the motion takes energy. One that helps it delivers energy, of which at most `left` remains.
  // The factor recovers slowly: a force that returned as soon as the motion turns would deliver energy when it turns
  // again, before that is observed.
  double share = std::fmin(1.0, loop.share + s.period_s / recovery_s);
  if (power > 0 && share * power * unseen > 0.5 * left) share = std::fmax(0.0, 0.5 * left) / (power * unseen);
  loop.share = share;
  Vector result = share < 1 ? share * force : force;
  if (s.least_mass_kg > 0) {
    // A motion can turn before that is observed: a force f moves a mass m within the time t by f t^2 / (2 m) and so
    // delivers up to f^2 t^2 / (2 m).
    const double may_deliver = std::fmax(left, 0.125 * s.allowance_J);
    result = shortened(result, std::sqrt(2 * s.least_mass_kg * may_deliver) / unseen);
  }
  if (left < 0 && speed2 > 0) {
    const double damping = std::fmin(-left / (unseen * speed2), s.largest_damping_Ns_per_m);
    result = result - damping * velocity;
  }
  loop.limited += !equal(result, force);
  return result;
}

}  // namespace phynness::loop
