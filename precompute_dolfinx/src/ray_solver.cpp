#include "ray_solver.hpp"

#include <algorithm>
#include <cmath>

namespace phynness {

RaySolver::Rest RaySolver::rest() {
  const int n_parameters = _equilibrium.constraint().n_parameters();
  const std::vector<double> zero(_body.n_dofs(), 0.0);
  auto linear = _equilibrium.linearize(zero, Eigen::MatrixXd::Identity(n_parameters, n_parameters));
  if (linear.status != Status::converged || !linear.sensitivity.allFinite() || !linear.tangent.allFinite())
    throw failure("the tangent at rest is singular", "factorization failed",
                  "fix more nodes: at least three that are not on one line hold a body");
  return {std::move(linear.sensitivity), std::move(linear.tangent), linear.negative_pivots};
}

std::vector<double> RaySolver::predict(const PathPoint* before, const PathPoint& from,
                                       const Eigen::VectorXd& direction, double s, bool curved) const {
  const auto n = static_cast<Eigen::Index>(from.state.size());
  const Eigen::Map<const Eigen::VectorXd> x1(from.state.data(), n);
  const double h = s - from.s;
  Eigen::VectorXd x = x1 + h * from.velocity;
  if (curved && before != nullptr) {
    // Cubic through two states and their velocities, continued to s (t counts in steps of the last interval).
    const Eigen::Map<const Eigen::VectorXd> x0(before->state.data(), n);
    const double last = from.s - before->s, t = h / last;
    const Eigen::VectorXd a = x1 - x0 - last * before->velocity;                  // curvature of the interval
    const Eigen::VectorXd b = last * (from.velocity - before->velocity) - 2 * a;  // and its change
    // With t' = 1 + t on [0, 1]:  x = x0 + v0 t' + a t'^2 + b t'^2 (t' - 1)
    const double tt = 1 + t;
    x = x0 + tt * last * before->velocity + tt * tt * a + tt * tt * (tt - 1) * b;
  }
  // Prescribed dofs are what the path says, to the last bit.
  const auto& constraint = _equilibrium.constraint();
  const Eigen::VectorXd prescribed = constraint.G * (s * direction);
  for (std::size_t i = 0; i < constraint.dofs.size(); ++i)
    x[constraint.dofs[i]] = prescribed[static_cast<Eigen::Index>(i)];
  return {x.data(), x.data() + n};
}

PathStep RaySolver::advance(const PathPoint* before, const PathPoint& from, const Eigen::VectorXd& direction,
                            double s, bool all_tangents, PathPoint& to) {
  const bool check_J = _body.forms().checks_jacobian;
  to.s = s;
  to.state = predict(before, from, direction, s, true);
  if (before != nullptr && check_J && !(_body.min_jacobian(to.state) > 0))
    to.state = predict(before, from, direction, s, false);

  PathStep step;
  const auto outcome = _equilibrium.solve(to.state);
  step.status = outcome.status;
  step.iterations = outcome.iterations;
  if (step.status != Status::converged) return step;
  to.min_jacobian = _body.min_jacobian(to.state);
  if (check_J && !(to.min_jacobian > 0)) {
    step.status = Status::inverted;
    return step;
  }
  const auto n_parameters = direction.size();
  const auto linear = _equilibrium.linearize(
      to.state, all_tangents ? Eigen::MatrixXd(Eigen::MatrixXd::Identity(n_parameters, n_parameters))
                             : Eigen::MatrixXd(direction));
  if (linear.status != Status::converged || !linear.sensitivity.allFinite()) {
    step.status = Status::factorization;
    return step;
  }
  to.velocity =
      all_tangents ? Eigen::VectorXd(linear.sensitivity * direction) : Eigen::VectorXd(linear.sensitivity);
  to.tangent = all_tangents ? linear.tangent : Eigen::MatrixXd();
  to.negative_pivots = linear.negative_pivots;
  to.force = _equilibrium.force(to.state);
  to.energy = _body.energy(to.state);
  return step;
}

void RaySolver::follow(const Rest& rest, const Eigen::VectorXd& direction,
                       const std::vector<double>& s_values, bool all_tangents,
                       const std::function<bool(std::size_t, const PathStep&, const PathPoint&)>& take) {
  PathPoint from, before;
  from.state.assign(_body.n_dofs(), 0.0);
  from.velocity = rest.sensitivity * direction;
  bool has_before = false, failed = false;

  for (std::size_t i = 0; i < s_values.size(); ++i) {
    PathStep total;
    const double increment = s_values[i] - from.s;
    const double shortest = increment * std::ldexp(1.0, -_options.max_cutbacks) * (1 - 1e-9);
    double h = increment;
    while (!failed && from.s < s_values[i]) {
      h = std::min(h, s_values[i] - from.s);
      const bool last = from.s + h * (1 + 1e-9) >= s_values[i];
      PathPoint to;
      const auto step = advance(has_before ? &before : nullptr, from, direction,
                                last ? s_values[i] : from.s + h, all_tangents && last, to);
      total.iterations += step.iterations;
      if (step.status == Status::converged) {
        std::swap(before, from);
        from = std::move(to);
        has_before = true;
        h *= 2;
      } else {
        ++total.cutbacks;
        h /= 2;
        if (h < shortest) {
          failed = true;
          total.status = step.status;
        }
      }
    }
    if (failed && total.status == Status::converged) total.status = Status::after_failure;
    if (!take(i, total, from)) return;
  }
}

}  // namespace phynness
