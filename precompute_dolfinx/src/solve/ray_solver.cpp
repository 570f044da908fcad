#include "ray_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>

#include "study/solver_log.hpp"

namespace phynness {

RaySolver::Rest RaySolver::rest() {
  if (!_equilibrium.is_usable()) _equilibrium.recover();
  const int n_parameters = _equilibrium.constraint().n_parameters();
  const std::vector<double> zero(_body.n_dofs(), 0.0);
  auto linear = _equilibrium.linearize(zero, Eigen::MatrixXd::Identity(n_parameters, n_parameters));
  if (linear.status != Status::converged || !linear.sensitivity.allFinite() || !linear.tangent.allFinite())
    throw failure("the tangent at rest is singular", "factorization failed",
                  "fix more nodes: at least three nodes that are not on one line");
  return {std::move(linear.sensitivity), std::move(linear.tangent), linear.negative_pivots};
}

Prediction RaySolver::predict(const Path& path, double s, PathPoint& to) {
  const bool check_J = _body.forms().checks_jacobian;
  const auto& constraint = _equilibrium.constraint();
  const Eigen::VectorXd prescribed = constraint.G * (s * _direction);
  // Predictions from more points follow the curvature of the path better, but are worse after a jump. The prediction
  // with the lowest energy is used; for mixed elements, whose equilibria are saddle points, only J is checked.
  Prediction predicted;
  double lowest = std::numeric_limits<double>::infinity();
  for (int k = path.n_points(s); k >= 1; --k) {
    auto candidate = path.predict(k, s);
    // The tools are set exactly to their displacements on the path.
    constraint.complete({candidate.state.data(), static_cast<std::size_t>(candidate.state.size())}, prescribed);
    to.state.assign(candidate.state.begin(), candidate.state.end());
    const bool mixed = !_body.pressure_dofs().empty();
    const double energy = !mixed                                           ? _body.energy(to.state)
                          : check_J && !(_body.min_jacobian(to.state) > 0) ? std::numeric_limits<double>::infinity()
                                                                           : 0;
    if (k == 1 ? energy < lowest || predicted.state.size() == 0 : energy < lowest) {
      lowest = energy;
      predicted = std::move(candidate);
    }
    if (mixed && lowest == 0) break;
  }
  to.state.assign(predicted.state.begin(), predicted.state.end());
  return predicted;
}

Status RaySolver::linearize(const Prediction& predicted, bool all_tangents, PathPoint& to) {
  if (all_tangents || to.has_buckled) {
    const auto n_parameters = _direction.size();
    const auto linear = _equilibrium.linearize(to.state, Eigen::MatrixXd::Identity(n_parameters, n_parameters));
    if (linear.status != Status::converged || !linear.sensitivity.allFinite()) return Status::factorization;
    to.velocity = linear.sensitivity * _direction;
    to.stiffness = _direction.dot(linear.tangent * _direction);
    to.tangent = linear.tangent;
    to.negative_pivots = linear.negative_pivots;
  } else {
    const Eigen::Map<const Eigen::VectorXd> state(to.state.data(), predicted.state.size());
    auto velocity =
        _equilibrium.velocity(to.state, _direction, predicted.velocity + predicted.growth * (state - predicted.state));
    to.velocity = std::move(velocity.rate);
    to.stiffness = velocity.stiffness;
    to.exact_stiffness = false;
    to.tangent.resize(0, 0);
    const auto pivots = to.velocity.allFinite() ? _equilibrium.negative_pivots(to.state) : std::nullopt;
    if (!pivots) return Status::factorization;
    to.negative_pivots = *pivots;
  }
  // Fewer negative pivots than pressures: for J > e a coupling of p and J is no longer concave in p, and the continuous
  // body does not have this equilibrium. Without tangents the count may belong to an earlier state.
  if (to.negative_pivots < 0 && !all_tangents && !to.has_buckled) {
    const auto again = _equilibrium.linearize(to.state, Eigen::MatrixXd(_direction.size(), 0));
    if (again.status != Status::converged) return Status::factorization;
    to.negative_pivots = again.negative_pivots;
  }
  return to.negative_pivots < 0 ? Status::diverged : Status::converged;
}

PathStep RaySolver::advance(const Path& path, double s, bool all_tangents, PathPoint& to) {
  const Prediction predicted = predict(path, s, to);
  to.s = s;
  PathStep step;
  const auto outcome = _equilibrium.solve(to.state, path.last().met_instability);
  step.status = outcome.status;
  step.iterations = outcome.iterations;
  if (step.status != Status::converged) return step;
  to.force = outcome.force;
  to.min_jacobian = _body.min_jacobian(to.state);
  if (_body.forms().checks_jacobian && !(to.min_jacobian > 0)) {
    step.status = Status::inverted;
    return step;
  }
  to.met_instability = path.last().met_instability || outcome.met_instability;
  to.has_buckled = outcome.has_left_saddle;
  step.status = linearize(predicted, all_tangents, to);
  if (step.status != Status::converged) return step;
  to.energy = _body.energy(to.state);
  if (!std::isfinite(to.energy)) step.status = Status::not_finite;
  return step;
}

void RaySolver::log_exceptions(const std::function<void()>& work) {
  try {
    if (!_equilibrium.is_usable()) _equilibrium.recover();
    return work();
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    SolverLog::instance().write(error.what());
  }
  _equilibrium.recover();
}

PathStep RaySolver::try_advance(const Path& path, double s, bool all_tangents, PathPoint& to) {
  PathStep step;
  step.status = Status::library_error;
  log_exceptions([&] { step = advance(path, s, all_tangents, to); });
  return step;
}

PathStep RaySolver::advance_to(double s, bool all_tangents) {
  PathStep total;
  const double increment = s - _path.last().s;
  const double shortest = increment * std::ldexp(1.0, -_options.max_cutbacks) * (1 - 1e-9);
  double h = increment;
  while (_path.last().s < s) {
    h = std::min(h, s - _path.last().s);
    const bool last = _path.last().s + h * (1 + 1e-9) >= s;
    PathPoint to;
    const auto step = try_advance(_path, last ? s : _path.last().s + h, all_tangents && last, to);
    total.iterations += step.iterations;
    if (step.status == Status::converged) {
      if (!accept(std::move(to), all_tangents && last, total.iterations)) {
        total.status = Status::after_end;
        return total;
      }
      h *= 2;
    } else {
      ++total.cutbacks;
      h /= 2;
      // A step that rounding loses would be repeated without end.
      if (h < shortest || !(_path.last().s + h > _path.last().s)) {
        total.status = step.status;
        return total;
      }
    }
  }
  return total;
}

RayEnd RaySolver::follow(const Rest& rest, const Eigen::VectorXd& direction, const std::vector<double>& s_values,
                         bool all_tangents,
                         const std::function<bool(std::size_t, const PathStep&, const PathPoint&)>& on_state,
                         const PathLimits& limits) {
  _direction = direction;
  _limits = limits;
  _path = {};
  PathPoint start;
  start.state.assign(_body.n_dofs(), 0.0);
  start.velocity = rest.sensitivity * direction;
  start.stiffness = direction.dot(rest.tangent * direction);
  _path.append(std::move(start));
  _end = {};
  _end.reason = EndReason::full_depth;
  Status remaining_status = Status::converged;  // of the increments that are left

  for (std::size_t i = 0; i < s_values.size(); ++i) {
    PathStep step;
    step.status = remaining_status;
    if (remaining_status == Status::converged) {
      step = advance_to(s_values[i], all_tangents);
      if (step.status == Status::converged) {
        _end.depth_m = s_values[i];
        if (_end.reason == EndReason::force_limit && i + 1 < s_values.size())
          remaining_status = Status::after_end;
        else
          _end.reason = EndReason::full_depth;
      } else if (step.status == Status::after_end) {
        remaining_status = Status::after_end;
      } else {
        remaining_status = Status::after_failure;
        _end.reason = EndReason::solver;
        _end.depth_m = _path.last().s;
      }
    }
    if (!on_state(i, step, _path.last())) return _end;
  }
  return _end;
}

}  // namespace phynness
