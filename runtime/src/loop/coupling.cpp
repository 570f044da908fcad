// Virtual coupling: a spring and a damper between the device and a tool without mass, which is where the forces of
// spring and body balance. Each cycle makes one Newton step.
#include "loop.hpp"

namespace phynness::loop {

namespace {

Matrix rotation_of(const phn_loop_settings& settings) {
  Matrix rotation;
  for (int i = 0; i < 9; ++i) rotation.a[i] = settings.rotation[i];
  return rotation;
}

/// Solves (K + a I) x = b; K symmetric, K + a I positive definite.
Vector solve(const double* K, double a, Vector b) {
  const double p = K[0] + a, q = K[4] + a, r = K[8] + a, u = K[1], v = K[2], w = K[5];
  const double c00 = q * r - w * w, c01 = w * v - u * r, c02 = u * w - q * v;
  const double c11 = p * r - v * v, c12 = u * v - p * w, c22 = p * q - u * u;
  const double scale = 1 / (p * c00 + u * c01 + v * c02);
  return scale * (Matrix{{c00, c01, c02, c01, c11, c12, c02, c12, c22}} * b);
}

/// A lower bound of the eigenvalues of a symmetric matrix (Gershgorin).
double softest(const double* K) {
  const double u = std::fabs(K[1]), v = std::fabs(K[2]), w = std::fabs(K[5]);
  return std::fmin(K[0] - u - v, std::fmin(K[4] - u - w, K[8] - v - w));
}

/// Newton step of the balance of the coupling [N/m, body frame] with the body.
Vector newton_step(phn_loop& loop, const phn_loop_response& response, double coupling, Vector unbalanced) {
  double K[9] = {};
  if (response.has_stiffness != 0) {
    for (int i = 0; i < 9; ++i) K[i] = response.stiffness[i];
  } else {
    // The step finds the balance if the tangent and the coupling together are at most twice as stiff as this secant and
    // the coupling together.
    const Vector d = vector_at(response.displacement);
    const double d2 = dot(d, d), secant = d2 > 0 ? std::fmax(0.0, dot(vector_at(response.force), d) / d2) : 0;
    loop.tangent.update(vector_at(response.force), d, loop.settings.period_s, coupling, secant, unbalanced);
    K[0] = K[4] = K[8] = std::fmax(secant, loop.tangent.stiffness);
  }
  // Where the body softens more than half as fast as the coupling is stiff, the step is damped.
  const double damped = std::fmax(0.0, -0.5 * coupling - softest(K));
  return solve(K, coupling + damped, unbalanced);
}

}  // namespace

void TangentEstimate::update(Vector new_force, Vector new_displacement, double period, double coupling, double secant,
                             Vector unbalanced) {
  constexpr double memory_s = 0.05;
  stiffness *= std::fmax(0.0, 1 - period / memory_s);
  const Vector change = new_force - force, motion = new_displacement - displacement;
  // Before a body has settled it returns the force of the cycle before, which belongs to an older displacement.
  if (has_last && dot(change, change) == 0) return;
  const double square = has_last ? dot(motion, motion) : 0, tangent = square > 0 ? dot(change, motion) / square : 0;
  if (dot(motion, unbalanced) < 0 && tangent > coupling + 2 * secant) stiffness = std::fmax(stiffness, tangent);
  force = new_force;
  displacement = new_displacement;
  has_last = true;
}

void ToolPath::add(Vector tool) {
  for (int i = n_velocity; i > 0; --i) last[i] = last[i - 1];
  last[0] = tool;
  if (n < n_velocity + 1) ++n;
}

Vector ToolPath::velocity(double period) const {
  return n < 2 ? Vector{} : (1 / ((n - 1) * period)) * (last[0] - last[n - 1]);
}

Vector to_body(const phn_loop& loop, Vector x) {
  const phn_loop_settings& s = loop.settings;
  return vector_at(s.origin_m) + s.motion_scale * (rotation_of(s) * x);
}

Vector vector_to_device(const phn_loop& loop, Vector body) {
  return (1 / loop.settings.motion_scale) * transposed_times(rotation_of(loop.settings), body);
}

Vector force_to_device(const phn_loop& loop, Vector body) {
  return loop.settings.force_scale * transposed_times(rotation_of(loop.settings), body);
}

Vector predicted(const phn_loop& loop, double now) {
  const phn_loop_settings& s = loop.settings;
  const double ahead = now - loop.observer.time() + 0.5 * s.period_s;
  Vector moved = ahead * loop.observer.velocity(n_velocity);
  if (s.trip_jump_m > 0) moved = limited_length(moved, s.trip_jump_m);
  return loop.observer.position() + moved;
}

Vector couple(phn_loop& loop, const phn_loop_response& response, double now, double& stored) {
  const phn_loop_settings& s = loop.settings;
  const Vector target = to_body(loop, predicted(loop, now));
  stored = 0;
  if (!loop.has_tool || response.in_contact == 0) {
    loop.tool = target;
    loop.has_tool = true;
    loop.tangent = {};
    loop.path.n = 0;
    loop.path.add(vector_to_device(loop, loop.tool));
    return {};
  }
  const double coupling = s.coupling_N_per_m / (s.force_scale * s.motion_scale);
  const Vector of_body = vector_at(response.force), displacement = vector_at(response.displacement);
  Vector step = newton_step(loop, response, coupling, coupling * (target - loop.tool) - of_body);
  if (s.reach_m > 0 && length(displacement + step) > s.reach_m)
    step = limited_length(displacement + step, s.reach_m) - displacement;
  if (!is_finite(step)) {
    trip(loop, PHN_TRIP_NOT_FINITE);
    return {};
  }
  loop.tool = loop.tool + step;
  loop.path.add(vector_to_device(loop, loop.tool));

  const Vector stretch = loop.tool - target;
  // Where the energy is not known, force . displacement is an upper bound of it as long as the body stiffens.
  const double of_tissue = response.energy >= 0 ? response.energy : std::fmax(0.0, dot(of_body, displacement));
  stored = s.force_scale / s.motion_scale * (of_tissue + 0.5 * coupling * dot(stretch, stretch));
  const Vector slip = loop.observer.velocity(n_velocity) - loop.path.velocity(s.period_s);
  return force_to_device(loop, coupling * stretch) - s.coupling_damping_Ns_per_m * slip;
}

}  // namespace phynness::loop
