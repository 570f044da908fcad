#include "equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "equilibrium_impl.hpp"

namespace phynness {

Equilibrium::Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& options,
                         LinearSolver* shared)
    : _impl(std::make_unique<Impl>(body, fixed_dofs, options, shared)) {
  prescribe({});
}
Equilibrium::~Equilibrium() = default;
Equilibrium::Equilibrium(Equilibrium&&) noexcept = default;

void Equilibrium::prescribe(Constraint constraint) {
  auto& s = *_impl;
  s.constraint = std::move(constraint);
  s.is_free.assign(s.body.n_dofs(), 1);
  for (int dof = 0; dof < s.body.n_dofs(); ++dof)
    if (s.tangent.unknown_of()[dof] < 0) s.is_free[dof] = 0;
  for (const auto dof : s.constraint.dofs) s.is_free[dof] = 0;
  if (!s.tangent.constrain(s.constraint)) return;
  // The sparsity pattern has changed, and with it everything that libraries have made of it.
  s.usable = false;
  recover();
}

void Equilibrium::recover() {
  auto& s = *_impl;
  s.usable = false;
  s.snes = {};
  s.x = {};
  s.r = {};
  s.quasi_newton.clear();
  s.pressures = PressureBlock(unknowns_of(s.tangent, s.body.pressure_dofs()));
  s.linear->reset();
  s.set_up_solver();
  s.usable = true;
}

bool Equilibrium::is_usable() const { return _impl->usable; }

SolverCounts Equilibrium::counts() const { return _impl->counts; }
const Constraint& Equilibrium::constraint() const { return _impl->constraint; }

void Equilibrium::set_load(std::vector<double> load) {
  _impl->load_norm = Eigen::Map<const Eigen::VectorXd>(load.data(), static_cast<Eigen::Index>(load.size())).norm();
  _impl->load = std::move(load);
}

void Equilibrium::set_stop(std::function<bool()> stop, double patience_s) {
  _impl->stop = std::move(stop);
  _impl->patience_s = patience_s;
  _impl->asked_to_end.reset();
}

bool Equilibrium::Impl::must_end() {
  if (!stop || !stop()) return false;
  const auto now = std::chrono::steady_clock::now();
  if (!asked_to_end) asked_to_end = now;
  return std::chrono::duration<double>(now - *asked_to_end).count() >= patience_s;
}

SNESConvergedReason Equilibrium::Impl::iterate(bool from_convex, int most_iterations, int& iterations) {
  if (must_end()) throw Interrupted();
  PHYNNESS_PETSC(SNESSetTolerances(snes, 0, 0, 0, most_iterations, 100 * most_iterations));
  hold();
  spread(x);
  refresh = true;
  convex = from_convex;
  strictly = false;
  linear_failed = false;
  trouble = nullptr;
  const auto code = SNESSolve(snes, nullptr, x);
  if (trouble) std::rethrow_exception(std::exchange(trouble, nullptr));
  petsc_check(code, "SNESSolve");
  if (must_end()) throw Interrupted();
  SNESConvergedReason reason;
  PetscInt n = 0;
  PHYNNESS_PETSC(SNESGetConvergedReason(snes, &reason));
  PHYNNESS_PETSC(SNESGetIterationNumber(snes, &n));
  iterations += static_cast<int>(n);
  // The latest residual belongs to the last trial, and a line search ends with the accepted trial.
  gather(x);
  return linear_failed && reason < 0 ? SNES_DIVERGED_LINEAR_SOLVE : reason;
}

bool Equilibrium::Impl::factorize_exact() {
  tangent.assemble(body, state);
  ++counts.tangents;
  factors_are_convex = false;
  quasi_newton.clear();
  return factorize();
}

bool Equilibrium::Impl::stays_at_saddle(SNESConvergedReason reason, bool check) {
  // Near a saddle point, to which Newton's method would converge, a line search fails because of rounding.
  const bool search_failed = reason == SNES_DIVERGED_LINE_SEARCH || reason == SNES_DIVERGED_LOCAL_MIN;
  if (reason < 0 ? !search_failed || !factors_are_convex : !check) return false;
  // The present factors may belong to an earlier state.
  return factorize_exact() && negative_pivots() > 0 && (!body.forms().checks_jacobian || body.min_jacobian(state) > 0);
}

Equilibrium::Outcome Equilibrium::solve(std::span<double> state, bool check_stability) {
  constexpr int most_saddles = 4;
  auto& s = *_impl;
  Outcome outcome;
  s.met_instability = false;
  const int most = static_cast<int>(s.most_iterations);
  SNESConvergedReason reason = SNES_DIVERGED_LINEAR_SOLVE;
  // If the true tangent cannot be factorized, element tangents are made positive semidefinite.
  for (const bool convex : {false, true}) {
    if (reason != SNES_DIVERGED_LINEAR_SOLVE) break;
    s.state.assign(state.begin(), state.end());
    s.pressures.forget();
    reason = s.iterate(convex, most, outcome.iterations);
  }
  for (int i = 0; i < most_saddles; ++i) {
    if (!s.stays_at_saddle(reason, check_stability || s.met_instability)) break;
    const auto saddle = s.state;
    if (!s.leave_saddle()) {  // the state remains, with its own factors
      s.state = saddle;
      s.evaluate_residual();
      s.factorize_exact();
      break;
    }
    outcome.left_saddle = true;
    reason = s.iterate(false, 5 * most, outcome.iterations);
  }
  outcome.met_instability = s.met_instability || outcome.left_saddle;
  if (reason > 0) {
    std::copy(s.state.begin(), s.state.end(), state.begin());
    const double scale = s.reaction_norm + s.load_norm;
    outcome.relative_residual = scale > 0 ? s.free_norm() / scale : 0;
    outcome.force = s.reaction();
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
  auto& s = *_impl;
  if (s.must_end()) throw Interrupted();
  s.state.assign(state.begin(), state.end());
  const auto coupling = s.tangent.assemble(s.body, s.state);
  ++s.counts.tangents;
  s.factors_are_convex = false;
  s.quasi_newton.clear();
  s.counts.substitutions += directions.cols();
  Linearization out;
  out.status = Status::factorization;
  if (!s.factorize()) return out;
  out.negative_pivots = s.negative_pivots();

  const Eigen::Index k = directions.cols();
  out.sensitivity = Eigen::MatrixXd::Zero(s.body.n_dofs(), k);
  out.tangent = coupling.corner * directions;
  for (Eigen::Index c = 0; c < k; ++c) {
    WriteValues(s.r).map() = -coupling.columns * directions.col(c);
    if (!s.linear->solve(s.r, s.x)) return out;
    const ReadValues dx(s.x);
    out.tangent.col(c) += coupling.columns.transpose() * dx.map();
    for (int i = 0; i < s.tangent.n_unknowns(); ++i) out.sensitivity(s.tangent.dof_of()[i], c) = dx[i];
    s.constraint.complete({out.sensitivity.col(c).data(), static_cast<std::size_t>(out.sensitivity.rows())},
                          s.constraint.G * directions.col(c));
  }
  out.status = Status::converged;
  return out;
}

Equilibrium::Velocity Equilibrium::velocity(std::span<const double> state, const Eigen::VectorXd& direction,
                                            Eigen::VectorXd guess) {
  auto& s = *_impl;
  const Eigen::VectorXd held = s.constraint.G * direction;
  s.constraint.complete({guess.data(), static_cast<std::size_t>(guess.size())}, held);
  const Eigen::Map<const Eigen::VectorXd> x0(state.data(), static_cast<Eigen::Index>(state.size()));
  // K guess by a central difference. Its truncation error is proportional to the square of the step, and rounding to
  // its inverse; with a step of 1e-5 of the body both leave about ten digits.
  const double epsilon = 1e-5 / guess.lpNorm<Eigen::Infinity>();
  std::vector<double> forward;
  for (const double sign : {1.0, -1.0}) {
    Eigen::Map<Eigen::VectorXd>(s.state.data(), x0.size()) = x0 + sign * epsilon * guess;
    s.evaluate_residual();
    if (sign > 0) forward = s.condensed;
  }
  {
    const WriteValues rates(s.r);
    for (int i = 0; i < s.tangent.n_unknowns(); ++i) {
      const auto dof = s.tangent.dof_of()[i];
      rates[i] = s.is_free[dof] ? (forward[dof] - s.condensed[dof]) / (2 * epsilon) : 0.0;
    }
  }
  // The masters' rows contain the work of dependent dofs except for that of G q.
  Eigen::VectorXd rate = guess;
  for (std::size_t i = 0; i < s.constraint.dofs.size(); ++i)
    rate[s.constraint.dofs[i]] = held[static_cast<Eigen::Index>(i)];
  double stiffness = 0;
  for (Eigen::Index dof = 0; dof < rate.size(); ++dof)
    stiffness += rate[dof] * (forward[dof] - s.condensed[dof]) / (2 * epsilon);
  ++s.counts.substitutions;
  if (!s.linear->solve(s.r, s.x)) return {Eigen::VectorXd::Constant(guess.size(), std::nan("")), stiffness};
  s.quasi_newton.apply(s.x);
  const ReadValues correction(s.x);
  for (int i = 0; i < s.tangent.n_unknowns(); ++i) {
    const auto dof = s.tangent.dof_of()[i];
    if (s.is_free[dof]) guess[dof] -= correction[i];
  }
  s.constraint.complete({guess.data(), static_cast<std::size_t>(guess.size())}, held);
  return {std::move(guess), stiffness};
}

std::optional<int> Equilibrium::negative_pivots(std::span<const double> state) {
  auto& s = *_impl;
  // A convex tangent has no negative pivots in any state.
  if (!s.factors_are_convex) return s.negative_pivots();
  const auto exact = linearize(state, Eigen::MatrixXd(s.constraint.n_parameters(), 0));
  if (exact.status != Status::converged) return std::nullopt;
  return exact.negative_pivots;
}

Eigen::VectorXd Equilibrium::force(std::span<const double> state) {
  auto& s = *_impl;
  s.state.assign(state.begin(), state.end());
  s.evaluate_residual();
  return s.reaction();
}

}  // namespace phynness
