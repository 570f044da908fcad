#include "equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace phynness {
namespace {

/// The numbers of the unknowns of these dofs.
std::vector<std::int32_t> unknowns_of(const TangentMatrix& tangent, std::span<const std::int32_t> dofs) {
  std::vector<std::int32_t> unknowns;
  for (const auto dof : dofs) unknowns.push_back(tangent.unknown_of()[dof]);
  return unknowns;
}

}  // namespace

Equilibrium::Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& options)
    : _body(body),
      _options(options),
      _tangent(body, fixed_dofs),
      _pressures(unknowns_of(_tangent, body.pressure_dofs())) {
  set_up_solver();
  _rounding_residual = rounding_residual();
  prescribe({});
}

void Equilibrium::prescribe(Constraint constraint) {
  _constraint = std::move(constraint);
  _is_free.assign(_body.n_dofs(), 1);
  for (int dof = 0; dof < _body.n_dofs(); ++dof)
    if (_tangent.unknown_of()[dof] < 0) _is_free[dof] = 0;
  for (const auto dof : _constraint.dofs) _is_free[dof] = 0;
  if (!_tangent.constrain(_constraint)) return;
  // The objects of the libraries depend on the sparsity pattern, which has changed.
  _is_usable = false;
  recover();
}

void Equilibrium::recover() {
  _is_usable = false;
  _snes = {};
  _x = {};
  _r = {};
  _quasi_newton.clear();
  _pressures = PressureBlock(unknowns_of(_tangent, _body.pressure_dofs()));
  _factorization.reset();
  set_up_solver();
  _is_usable = true;
}

void Equilibrium::set_stop(std::function<bool()> stop, double patience_s) {
  _stop = std::move(stop);
  _patience_s = patience_s;
  _stop_requested_at.reset();
}

bool Equilibrium::must_stop() {
  if (!_stop || !_stop()) return false;
  const auto now = std::chrono::steady_clock::now();
  if (!_stop_requested_at) _stop_requested_at = now;
  return std::chrono::duration<double>(now - *_stop_requested_at).count() >= _patience_s;
}

SNESConvergedReason Equilibrium::iterate(bool from_convex, int most_iterations, int& iterations) {
  if (must_stop()) throw Interrupted();
  PHYNNESS_PETSC(SNESSetTolerances(_snes, 0, 0, 0, most_iterations, 100 * most_iterations));
  store_prescribed();
  copy_unknowns(_x);
  _needs_tangent = true;
  _convex = from_convex;
  _needs_strict_convexity = false;
  _factorization_failed = false;
  _callback_exception = nullptr;
  const auto code = SNESSolve(_snes, nullptr, _x);
  if (_callback_exception) std::rethrow_exception(std::exchange(_callback_exception, nullptr));
  petsc_check(code, "SNESSolve");
  if (must_stop()) throw Interrupted();
  SNESConvergedReason reason;
  PetscInt n = 0;
  PHYNNESS_PETSC(SNESGetConvergedReason(_snes, &reason));
  PHYNNESS_PETSC(SNESGetIterationNumber(_snes, &n));
  iterations += static_cast<int>(n);
  // The latest residual is that of the accepted trial, with which a line search ends.
  set_state(_x);
  return _factorization_failed && reason < 0 ? SNES_DIVERGED_LINEAR_SOLVE : reason;
}

bool Equilibrium::factorize_exact() {
  _tangent.assemble(_body, _state);
  ++_counts.tangents;
  _factors_are_convex = false;
  _quasi_newton.clear();
  return factorize();
}

bool Equilibrium::is_at_saddle(SNESConvergedReason reason, bool check) {
  // Near a saddle point, to which Newton's method converges, the line search fails because of rounding.
  const bool search_failed = reason == SNES_DIVERGED_LINE_SEARCH || reason == SNES_DIVERGED_LOCAL_MIN;
  if (reason < 0 ? !search_failed || !_factors_are_convex : !check) return false;
  // The present factors may belong to an earlier state.
  return factorize_exact() && negative_pivots() > 0 &&
         (!_body.forms().checks_jacobian || _body.min_jacobian(_state) > 0);
}

Equilibrium::Outcome Equilibrium::solve(std::span<double> state, bool check_stability) {
  constexpr int most_saddles = 4;
  Outcome outcome;
  _met_instability = false;
  const int most = static_cast<int>(_most_iterations);
  SNESConvergedReason reason = SNES_DIVERGED_LINEAR_SOLVE;
  // If the true tangent cannot be factorized, element tangents are made positive semidefinite.
  for (const bool convex : {false, true}) {
    if (reason != SNES_DIVERGED_LINEAR_SOLVE) break;
    _state.assign(state.begin(), state.end());
    _pressures.reset();
    reason = iterate(convex, most, outcome.iterations);
  }
  for (int i = 0; i < most_saddles; ++i) {
    if (!is_at_saddle(reason, check_stability || _met_instability)) break;
    const auto saddle = _state;
    if (!leave_saddle()) {  // restores the state and its factors
      _state = saddle;
      evaluate_residual();
      factorize_exact();
      break;
    }
    outcome.has_left_saddle = true;
    reason = iterate(false, 5 * most, outcome.iterations);
  }
  outcome.met_instability = _met_instability || outcome.has_left_saddle;
  if (reason > 0) {
    std::copy(_state.begin(), _state.end(), state.begin());
    outcome.relative_residual = _reaction_norm > 0 ? free_residual_norm() / _reaction_norm : 0;
    outcome.force = reaction();
    return outcome;
  }
  switch (reason) {
    case SNES_DIVERGED_LINEAR_SOLVE:
      outcome.status = Status::factorization;
      break;
    case SNES_DIVERGED_FUNCTION_DOMAIN:
    case SNES_DIVERGED_FUNCTION_NANORINF:
      outcome.status = Status::not_finite;
      break;
    default:
      outcome.status = Status::diverged;
  }
  return outcome;
}

Equilibrium::Linearization Equilibrium::linearize(std::span<const double> state, const Eigen::MatrixXd& directions) {
  if (must_stop()) throw Interrupted();
  _state.assign(state.begin(), state.end());
  const auto coupling = _tangent.assemble(_body, _state);
  ++_counts.tangents;
  _factors_are_convex = false;
  _quasi_newton.clear();
  _counts.substitutions += directions.cols();
  Linearization out;
  out.status = Status::factorization;
  if (!factorize()) return out;
  out.negative_pivots = negative_pivots();

  const Eigen::Index k = directions.cols();
  out.sensitivity = Eigen::MatrixXd::Zero(_body.n_dofs(), k);
  out.tangent = coupling.corner * directions;
  for (Eigen::Index c = 0; c < k; ++c) {
    WriteValues(_r).map() = -coupling.columns * directions.col(c);
    if (!_factorization.solve(_r, _x)) return out;
    const ReadValues dx(_x);
    out.tangent.col(c) += coupling.columns.transpose() * dx.map();
    for (int i = 0; i < _tangent.n_unknowns(); ++i) out.sensitivity(_tangent.dof_of()[i], c) = dx[i];
    _constraint.complete({out.sensitivity.col(c).data(), static_cast<std::size_t>(out.sensitivity.rows())},
                         _constraint.G * directions.col(c));
  }
  out.status = Status::converged;
  return out;
}

Eigen::MatrixXd Equilibrium::load_response(const Eigen::MatrixXd& loads) {
  if (must_stop()) throw Interrupted();
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(loads.rows(), loads.cols());
  const auto& dof_of = _tangent.dof_of();
  _counts.substitutions += loads.cols();
  for (Eigen::Index c = 0; c < loads.cols(); ++c) {
    WriteValues(_r).map() = loads.col(c)(dof_of);
    if (!_factorization.solve(_r, _x)) return {};
    change.col(c)(dof_of) = ReadValues(_x).map();
  }
  return change;
}

Equilibrium::Velocity Equilibrium::velocity(std::span<const double> state, const Eigen::VectorXd& direction,
                                            Eigen::VectorXd guess) {
  const Eigen::VectorXd prescribed_rate = _constraint.G * direction;
  _constraint.complete({guess.data(), static_cast<std::size_t>(guess.size())}, prescribed_rate);
  const auto x0 = as_vector(state);
  // K guess by a central difference. Its truncation error is proportional to the square of the step, and rounding to
  // its inverse; with a step of 1e-5 of the body both leave about ten digits.
  const double epsilon = 1e-5 / guess.lpNorm<Eigen::Infinity>();
  std::vector<double> forward;
  for (const double sign : {1.0, -1.0}) {
    as_vector(_state) = x0 + sign * epsilon * guess;
    evaluate_residual();
    if (sign > 0) forward = _condensed;
  }
  {
    const WriteValues rates(_r);
    for (int i = 0; i < _tangent.n_unknowns(); ++i) {
      const auto dof = _tangent.dof_of()[i];
      rates[i] = _is_free[dof] ? (forward[dof] - _condensed[dof]) / (2 * epsilon) : 0.0;
    }
  }
  // The masters' rows contain the work of dependent dofs except for that of G q.
  Eigen::VectorXd rate = guess;
  rate(_constraint.dofs) = prescribed_rate;
  double stiffness = 0;
  for (Eigen::Index dof = 0; dof < rate.size(); ++dof)
    stiffness += rate[dof] * (forward[dof] - _condensed[dof]) / (2 * epsilon);
  ++_counts.substitutions;
  if (!_factorization.solve(_r, _x)) return {Eigen::VectorXd::Constant(guess.size(), std::nan("")), stiffness};
  _quasi_newton.apply(_x);
  const ReadValues correction(_x);
  for (int i = 0; i < _tangent.n_unknowns(); ++i) {
    const auto dof = _tangent.dof_of()[i];
    if (_is_free[dof]) guess[dof] -= correction[i];
  }
  _constraint.complete({guess.data(), static_cast<std::size_t>(guess.size())}, prescribed_rate);
  return {std::move(guess), stiffness};
}

std::optional<int> Equilibrium::negative_pivots(std::span<const double> state) {
  // A convex tangent has no negative pivots in any state.
  if (!_factors_are_convex) return negative_pivots();
  const auto exact = linearize(state, Eigen::MatrixXd(_constraint.n_parameters(), 0));
  if (exact.status != Status::converged) return std::nullopt;
  return exact.negative_pivots;
}

Eigen::VectorXd Equilibrium::force(std::span<const double> state) {
  _state.assign(state.begin(), state.end());
  evaluate_residual();
  return reaction();
}

}  // namespace phynness
