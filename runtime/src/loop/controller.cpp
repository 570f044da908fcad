// Passivity controller: the loop must not deliver more energy than it took. docs/howto/haptic-loop.md derives it.
#include "loop.hpp"

namespace phynness::loop {

namespace {

constexpr double recovery_s = 0.05;

/// Adds the energy that a motion within a step of the positions may take, which is not observed. It may go one way at
/// the larger and back at the smaller force, because the controller's change depends on the direction of the motion.
void count_unobserved(phn_loop& loop, Vector change, Vector velocity) {
  const double step = loop.settings.position_resolution_m, slow = 0.25 * step / loop.settings.period_s;
  const Vector d = change - loop.change;
  double unobserved = 0;
  for (int k = 0; k < 3; ++k) unobserved += std::fabs(velocity[k]) < slow ? std::fabs(d[k]) : 0;
  loop.observer.work_error += 0.5 * step * unobserved;
  loop.change = change;
}

/// @param available  energy that may be delivered [J]
/// @param delay      time until the effect of the force is observed [s]
Vector limited(phn_loop& loop, Vector force, Vector velocity, double available, double delay) {
  const phn_loop_settings& s = loop.settings;
  const double mass = s.least_mass_kg, positive = std::fmax(0.0, available), size = length(force);
  Vector result = force;
  // A motion can turn before that is observed: a force f moves a mass m within the time t by f t^2 / (2 m) and so
  // delivers up to f^2 t^2 / (2 m).
  if (mass > 0) result = limited_length(result, std::sqrt(2 * mass * positive) / delay);
  // A force that helps the motion may deliver half of the available energy. The factor recovers slowly: a force that
  // returned as soon as the motion turns would deliver energy when it turns again, before that is observed.
  const double power = dot(result, velocity);
  double share = std::fmin(1.0, loop.share + s.period_s / recovery_s);
  if (power > 0 && share * power * delay > 0.5 * positive) share = 0.5 * positive / (power * delay);
  loop.share = share;
  if (share < 1) result = share * result;
  // A mass that moves with v against a force f < m v / t gives energy, because it does not turn before that is
  // observed. Velocities of up to one and a half steps of the positions do not count.
  const double noise = 1.5 * s.position_resolution_m / (n_velocity * s.period_s);
  const double against = size > 0 ? -dot(force, velocity) / size - noise : 0;
  const double braking = std::fmin(0.5 * mass * against, std::sqrt(2 * mass * s.allowance_J)) / delay;
  return length(result) < braking ? limited_length(force, braking) : result;
}

}  // namespace

double available_energy(const phn_loop& loop) {
  const Observer& o = loop.observer;
  return loop.settings.allowance_J + o.work + o.dissipated - o.work_error - loop.withheld;
}

Vector limit_energy(phn_loop& loop, Vector force, double stored, double now) {
  const phn_loop_settings& s = loop.settings;
  const Vector velocity = loop.observer.velocity(n_velocity);
  const double speed2 = dot(velocity, velocity);
  // The effect of this force is observed when the first sample arrives that was measured after it has acted.
  const double delay = std::fmax(0.0, now - loop.observer.time()) + s.period_s;
  const double pending = loop.observer.pending(velocity, now);
  // Dissipated energy must not be returned later, except for a reserve and the energy that is not observed yet.
  const double reserve = stored + s.largest_reserve_J + s.allowance_J + delay * length(loop.force) * std::sqrt(speed2);
  loop.withheld += std::fmax(0.0, available_energy(loop) - pending - reserve);

  const double available = available_energy(loop) - std::fmax(0.0, pending);
  Vector result = limited(loop, force, velocity, available, delay);
  if (available < 0 && speed2 > 0) {
    const double damping = std::fmin(-available / (delay * speed2), s.largest_damping_Ns_per_m);
    result = result - damping * velocity;
  }
  loop.limited += !equal(result, force);
  count_unobserved(loop, result - force, velocity);
  return result;
}

}  // namespace phynness::loop
