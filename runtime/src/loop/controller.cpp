// Passivity controller: the loop must not deliver more energy than it took. docs/howto/haptic-loop.md derives it.
#include "loop.hpp"

namespace phynness::loop {

namespace {

constexpr double recovery_s = 0.05;

/// Energy that may be lost in a motion within a step of the positions, which is not seen: it may run one way at the
/// larger and back at the smaller force, as what the controller changes depends on the direction of the motion.
void count_unseen(phn_loop& loop, Vector change, Vector velocity) {
  const double step = loop.settings.position_resolution_m, slow = 0.25 * step / loop.settings.period_s;
  const Vector d = change - loop.change;
  double seen = 0;
  for (int k = 0; k < 3; ++k) seen += std::fabs(velocity[k]) < slow ? std::fabs(d[k]) : 0;
  loop.observer.unsure += 0.5 * step * seen;
  loop.change = change;
}

/// @param left    energy that may be delivered [J]
/// @param unseen  time until the effect of the force is observed [s]
Vector limited(phn_loop& loop, Vector force, Vector velocity, double left, double unseen) {
  const phn_loop_settings& s = loop.settings;
  const double mass = s.least_mass_kg, positive = std::fmax(0.0, left), size = length(force);
  Vector result = force;
  // A motion can turn before that is observed: a force f moves a mass m within the time t by f t^2 / (2 m) and so
  // delivers up to f^2 t^2 / (2 m).
  if (mass > 0) result = shortened(result, std::sqrt(2 * mass * positive) / unseen);
  // A force that helps the motion delivers energy, of which at most half of what is left. The factor recovers slowly: a
  // force that returned as soon as the motion turns would deliver energy when it turns again, before that is observed.
  const double power = dot(result, velocity);
  double share = std::fmin(1.0, loop.share + s.period_s / recovery_s);
  if (power > 0 && share * power * unseen > 0.5 * positive) share = 0.5 * positive / (power * unseen);
  loop.share = share;
  if (share < 1) result = share * result;
  // A mass that moves against the force with v does not turn before that is observed if f < m v / t, and gives energy.
  // Velocities that may be one and a half steps of the positions are not counted.
  const double noise = 1.5 * s.position_resolution_m / (n_velocity * s.period_s);
  const double against = size > 0 ? -dot(force, velocity) / size - noise : 0;
  const double takes = std::fmin(0.5 * mass * against, std::sqrt(2 * mass * s.allowance_J)) / unseen;
  return length(result) < takes ? shortened(force, takes) : result;
}

}  // namespace

double budget(const phn_loop& loop) {
  const Observer& o = loop.observer;
  return loop.settings.allowance_J + o.work + o.dissipated - o.unsure - loop.forgotten;
}

Vector kept_passive(phn_loop& loop, Vector force, double stored, double now) {
  const phn_loop_settings& s = loop.settings;
  const Vector velocity = loop.observer.velocity(n_velocity);
  const double speed2 = dot(velocity, velocity);
  // The effect of this force is observed when the first sample arrives that was measured after it has acted.
  const double unseen = std::fmax(0.0, now - loop.observer.time()) + s.period_s;
  const double pending = loop.observer.pending(velocity, now);
  // Energy that was dissipated must not be returned later, except for a reserve and what is not observed yet.
  const double kept = stored + s.largest_reserve_J + s.allowance_J + unseen * length(loop.force) * std::sqrt(speed2);
  loop.forgotten += std::fmax(0.0, budget(loop) - pending - kept);

  const double left = budget(loop) - std::fmax(0.0, pending);
  Vector result = limited(loop, force, velocity, left, unseen);
  if (left < 0 && speed2 > 0) {
    const double damping = std::fmin(-left / (unseen * speed2), s.largest_damping_Ns_per_m);
    result = result - damping * velocity;
  }
  loop.limited += !equal(result, force);
  count_unseen(loop, result - force, velocity);
  return result;
}

}  // namespace phynness::loop
