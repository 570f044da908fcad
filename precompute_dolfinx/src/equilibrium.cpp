#include "equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "equilibrium_impl.hpp"
#include "factorization.hpp"

namespace phynness {
namespace {

std::vector<std::int32_t> unknowns_of(const TangentMatrix& tangent, std::span<const std::int32_t> dofs) {
  std::vector<std::int32_t> unknowns;
  for (const auto dof : dofs) unknowns.push_back(tangent.unknown_of()[dof]);
  return unknowns;
}

}  // namespace

Equilibrium::Impl::Impl(Discretization& discretization, const std::vector<std::int32_t>& fixed_dofs,
                        const SolverSpec& spec, Team* helpers)
    : body(discretization),
      options(spec),
      team(helpers),
      tangent(discretization, fixed_dofs),
      pressures(unknowns_of(tangent, discretization.pressure_dofs())) {
  set_up_solver();
  rounding = residual_of_rounding();
}

int Equilibrium::Impl::negative_pivots() const {
  KSP ksp;
  PHYNNESS_PETSC(SNESGetKSP(snes, &ksp));
  const int all = team ? team->negative_pivots() : phynness::negative_pivots(ksp);
  return all - static_cast<int>(body.pressure_dofs().size());
}

PetscErrorCode Equilibrium::Impl::factorize_together(PC pc) {
  Team* team = nullptr;
  Mat matrix;
  PetscCall(PCShellGetContext(pc, &team));
  PetscCall(PCGetOperators(pc, nullptr, &matrix));
  PetscCall(PCSetFailedReason(pc, team->factorize(matrix) ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
  return 0;
}

PetscErrorCode Equilibrium::Impl::solve_together(PC pc, Vec b, Vec x) {
  Team* team = nullptr;
  PetscCall(PCShellGetContext(pc, &team));
  team->solve(b, x);
  return 0;
}

void Equilibrium::Impl::set_up_solver() {
  state.assign(body.n_dofs(), 0.0);
  residual.assign(body.n_dofs(), 0.0);
  const auto n = static_cast<PetscInt>(tangent.n_unknowns());
  PHYNNESS_PETSC(VecCreateSeq(PETSC_COMM_SELF, n, x.address()));
  PHYNNESS_PETSC(VecDuplicate(x, r.address()));
  PHYNNESS_PETSC(SNESCreate(PETSC_COMM_SELF, snes.address()));
  PHYNNESS_PETSC(SNESSetOptionsPrefix(snes, "phynness_"));
  PHYNNESS_PETSC(SNESSetFunction(snes, r, form_function, this));
  PHYNNESS_PETSC(SNESSetJacobian(snes, tangent.matrix(), tangent.matrix(), form_jacobian, this));
  PHYNNESS_PETSC(SNESSetConvergenceTest(snes, test_convergence, this, nullptr));
  PHYNNESS_PETSC(SNESSetTolerances(snes, 0, 0, 0, options.max_iterations, 100 * options.max_iterations));
  KSP ksp;
  PC pc;
  PHYNNESS_PETSC(SNESGetKSP(snes, &ksp));
  PHYNNESS_PETSC(KSPSetType(ksp, KSPPREONLY));
  PHYNNESS_PETSC(KSPGetPC(ksp, &pc));
  SNESLineSearch search;
  PHYNNESS_PETSC(SNESGetLineSearch(snes, &search));
  PHYNNESS_PETSC(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  PHYNNESS_PETSC(SNESLineSearchShellSetApply(search, step, this));
  if (team) {
    PHYNNESS_PETSC(KSPSetOperators(ksp, tangent.matrix(), tangent.matrix()));
    PHYNNESS_PETSC(PCSetType(pc, PCSHELL));
    PHYNNESS_PETSC(PCShellSetContext(pc, team));
    PHYNNESS_PETSC(PCShellSetSetUp(pc, factorize_together));
    PHYNNESS_PETSC(PCShellSetApply(pc, solve_together));
  } else {
    set_up_factorization(ksp, tangent.matrix());
  }
  PHYNNESS_PETSC(SNESSetFromOptions(snes));
}

/// F = I + grad u is rounded to the last bit of 1, as if every point were off by that part of the body's
/// size. Without this floor a displacement of a millionth of the body could never meet a tolerance relative
/// to its own small forces.
double Equilibrium::Impl::residual_of_rounding() {
  const int m = body.n_element_dofs();
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(body.n_dofs());
  body.element_tangents(std::vector<double>(body.n_dofs(), 0.0),
                        [&](std::int32_t cell, std::span<const double> element) {
                          for (int i = 0; i < m; ++i)
                            diagonal[body.element_dofs(cell)[i]] += element[i * m + i];
                        });
  const Eigen::RowVector3d extent = body.points().colwise().maxCoeff() - body.points().colwise().minCoeff();
  return std::numeric_limits<double>::epsilon() / 2 * diagonal.norm() * extent.norm();
}

void Equilibrium::Impl::gather(Vec from) {
  const PetscScalar* values = nullptr;
  PHYNNESS_PETSC(VecGetArrayRead(from, &values));
  for (int i = 0; i < tangent.n_unknowns(); ++i) state[tangent.dof_of()[i]] = values[i];
  PHYNNESS_PETSC(VecRestoreArrayRead(from, &values));
}

void Equilibrium::Impl::spread(Vec to) const {
  PetscScalar* values = nullptr;
  PHYNNESS_PETSC(VecGetArray(to, &values));
  for (int i = 0; i < tangent.n_unknowns(); ++i) values[i] = state[tangent.dof_of()[i]];
  PHYNNESS_PETSC(VecRestoreArray(to, &values));
}

void Equilibrium::Impl::scatter(Vec to) const {
  PetscScalar* out = nullptr;
  PHYNNESS_PETSC(VecGetArray(to, &out));
  for (int i = 0; i < tangent.n_unknowns(); ++i) {
    const auto dof = tangent.dof_of()[i];
    out[i] = is_free[dof] ? residual[dof] : 0.0;
  }
  PHYNNESS_PETSC(VecRestoreArray(to, &out));
}

void Equilibrium::Impl::evaluate_residual() {
  body.residual(state, residual);
  ++counts.residuals;
  double reactions = 0;
  for (int dof = 0; dof < body.n_dofs(); ++dof) {
    if (!load.empty()) residual[dof] -= load[dof];
    if (!is_free[dof]) reactions += residual[dof] * residual[dof];
  }
  reaction_norm = std::sqrt(reactions);
}

Eigen::VectorXd Equilibrium::Impl::reaction() const {
  Eigen::VectorXd held(static_cast<Eigen::Index>(constraint.dofs.size()));
  for (std::size_t i = 0; i < constraint.dofs.size(); ++i)
    held[static_cast<Eigen::Index>(i)] = residual[constraint.dofs[i]];
  return constraint.G.transpose() * held;
}

double Equilibrium::Impl::free_norm() const {
  double sum = 0;
  for (int dof = 0; dof < body.n_dofs(); ++dof)
    if (is_free[dof]) sum += residual[dof] * residual[dof];
  return std::sqrt(sum);
}

PetscErrorCode Equilibrium::Impl::form_function(SNES snes, Vec x, Vec r, void* context) {
  auto& self = *static_cast<Impl*>(context);
  self.gather(x);
  self.evaluate_residual();
  self.scatter(r);
  // ln J with J <= 0: the line search must back off instead of taking NaN for an answer.
  if (!std::isfinite(self.free_norm())) PetscCall(SNESSetFunctionDomainError(snes));
  return 0;
}

PetscErrorCode Equilibrium::Impl::form_jacobian(SNES snes, Vec x, Mat, Mat, void* context) {
  auto& self = *static_cast<Impl*>(context);
  KSP ksp;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetReusePreconditioner(ksp, self.refresh ? PETSC_FALSE : PETSC_TRUE));
  ++self.counts.substitutions;
  self.fresh = self.refresh;
  if (!self.refresh) return 0;
  self.refresh = false;
  self.quasi_newton.clear();
  self.gather(x);
  self.tangent.assemble(self.body, self.state, self.constraint, self.prescribed, self.convex);
  self.pressures.set(self.tangent.matrix());
  self.factors_are_convex = self.convex;
  ++self.counts.tangents;
  ++self.counts.factorizations;  // KSPPREONLY follows
  return 0;
}

PetscErrorCode Equilibrium::Impl::test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal norm,
                                                   SNESConvergedReason* reason, void* context) {
  const auto& self = *static_cast<Impl*>(context);
  *reason = SNES_CONVERGED_ITERATING;
  if (!std::isfinite(norm))
    *reason = SNES_DIVERGED_FUNCTION_NANORINF;
  else if (norm <= self.goal())
    *reason = SNES_CONVERGED_FNORM_RELATIVE;
  return 0;
}

Equilibrium::Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs,
                         const SolverSpec& options, Team* team)
    : _impl(std::make_unique<Impl>(body, fixed_dofs, options, team && team->size() > 1 ? team : nullptr)) {
  prescribe({{}, Eigen::MatrixXd(0, 0)});
}
Equilibrium::~Equilibrium() = default;
Equilibrium::Equilibrium(Equilibrium&&) noexcept = default;

void Equilibrium::prescribe(Constraint constraint) {
  auto& s = *_impl;
  s.constraint = std::move(constraint);
  s.is_free.assign(s.body.n_dofs(), 1);
  for (int dof = 0; dof < s.body.n_dofs(); ++dof)
    if (s.tangent.unknown_of()[dof] < 0) s.is_free[dof] = 0;
  s.prescribed.clear();
  for (const auto dof : s.constraint.dofs) {
    s.prescribed.push_back(s.tangent.unknown_of()[dof]);
    s.is_free[dof] = 0;
  }
}

SolverCounts Equilibrium::counts() const { return _impl->counts; }
const Constraint& Equilibrium::constraint() const { return _impl->constraint; }

void Equilibrium::set_load(std::vector<double> load) {
  _impl->load_norm =
      Eigen::Map<const Eigen::VectorXd>(load.data(), static_cast<Eigen::Index>(load.size())).norm();
  _impl->load = std::move(load);
}

Equilibrium::Outcome Equilibrium::solve(std::span<double> state) {
  auto& s = *_impl;
  s.state.assign(state.begin(), state.end());
  s.spread(s.x);
  s.refresh = true;
  s.convex = false;
  s.pressures.forget();
  Outcome outcome;
  PHYNNESS_PETSC(SNESSolve(s.snes, nullptr, s.x));
  SNESConvergedReason reason;
  PetscInt iterations = 0;
  PHYNNESS_PETSC(SNESGetConvergedReason(s.snes, &reason));
  PHYNNESS_PETSC(SNESGetIterationNumber(s.snes, &iterations));
  outcome.iterations = static_cast<int>(iterations);
  if (reason > 0) {
    // The latest residual is that of the last trial, and a search ends with the trial that it takes.
    s.gather(s.x);
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

Equilibrium::Linearization Equilibrium::linearize(std::span<const double> state,
                                                  const Eigen::MatrixXd& directions) {
  auto& s = *_impl;
  s.state.assign(state.begin(), state.end());
  const auto coupling = s.tangent.assemble(s.body, s.state, s.constraint, s.prescribed);
  ++s.counts.tangents;
  ++s.counts.factorizations;
  s.factors_are_convex = false;
  s.quasi_newton.clear();
  s.counts.substitutions += directions.cols();
  Linearization out;
  KSP ksp;
  PC pc;
  PHYNNESS_PETSC(SNESGetKSP(s.snes, &ksp));
  PHYNNESS_PETSC(KSPSetOperators(ksp, s.tangent.matrix(), s.tangent.matrix()));
  PHYNNESS_PETSC(KSPSetReusePreconditioner(ksp, PETSC_FALSE));
  PHYNNESS_PETSC(KSPGetPC(ksp, &pc));
  PHYNNESS_PETSC(PCSetUp(pc));
  PCFailedReason failed;
  PHYNNESS_PETSC(PCGetFailedReason(pc, &failed));
  if (failed != PC_NOERROR) {
    out.status = Status::factorization;
    return out;
  }
  out.negative_pivots = s.negative_pivots();

  const Eigen::Index k = directions.cols();
  out.sensitivity = Eigen::MatrixXd::Zero(s.body.n_dofs(), k);
  out.tangent = coupling.corner * directions;
  for (Eigen::Index c = 0; c < k; ++c) {
    const Eigen::VectorXd rhs = -coupling.columns * directions.col(c);
    PetscScalar* values = nullptr;
    PHYNNESS_PETSC(VecGetArray(s.r, &values));
    std::copy(rhs.data(), rhs.data() + rhs.size(), values);
    PHYNNESS_PETSC(VecRestoreArray(s.r, &values));
    PHYNNESS_PETSC(KSPSolve(ksp, s.r, s.x));
    const PetscScalar* solution = nullptr;
    PHYNNESS_PETSC(VecGetArrayRead(s.x, &solution));
    const Eigen::Map<const Eigen::VectorXd> dx(solution, s.tangent.n_unknowns());
    out.tangent.col(c) += coupling.columns.transpose() * dx;
    for (int i = 0; i < s.tangent.n_unknowns(); ++i) out.sensitivity(s.tangent.dof_of()[i], c) = dx[i];
    PHYNNESS_PETSC(VecRestoreArrayRead(s.x, &solution));
    const Eigen::VectorXd prescribed = s.constraint.G * directions.col(c);
    for (std::size_t i = 0; i < s.constraint.dofs.size(); ++i)
      out.sensitivity(s.constraint.dofs[i], c) = prescribed[static_cast<Eigen::Index>(i)];
  }
  return out;
}

Eigen::VectorXd Equilibrium::velocity(std::span<const double> state, const Eigen::VectorXd& direction,
                                      Eigen::VectorXd guess) {
  auto& s = *_impl;
  const Eigen::VectorXd prescribed = s.constraint.G * direction;
  for (std::size_t i = 0; i < s.constraint.dofs.size(); ++i)
    guess[s.constraint.dofs[i]] = prescribed[static_cast<Eigen::Index>(i)];
  const Eigen::Map<const Eigen::VectorXd> x0(state.data(), static_cast<Eigen::Index>(state.size()));
  // K guess by a central difference: its error falls with the square of the step, rounding rises with its
  // inverse; a hundred-thousandth of the body leaves about ten digits of both.
  const double epsilon = 1e-5 / guess.lpNorm<Eigen::Infinity>();
  std::vector<double> forward;
  for (const double sign : {1.0, -1.0}) {
    Eigen::Map<Eigen::VectorXd>(s.state.data(), x0.size()) = x0 + sign * epsilon * guess;
    s.evaluate_residual();
    if (sign > 0) forward = s.residual;
  }
  PetscScalar* values = nullptr;
  PHYNNESS_PETSC(VecGetArray(s.r, &values));
  for (int i = 0; i < s.tangent.n_unknowns(); ++i) {
    const auto dof = s.tangent.dof_of()[i];
    values[i] = s.is_free[dof] ? (forward[dof] - s.residual[dof]) / (2 * epsilon) : 0.0;
  }
  PHYNNESS_PETSC(VecRestoreArray(s.r, &values));
  KSP ksp;
  PHYNNESS_PETSC(SNESGetKSP(s.snes, &ksp));
  PHYNNESS_PETSC(KSPSetReusePreconditioner(ksp, PETSC_TRUE));
  PHYNNESS_PETSC(KSPSolve(ksp, s.r, s.x));
  ++s.counts.substitutions;
  s.quasi_newton.apply(s.x);
  const PetscScalar* correction = nullptr;
  PHYNNESS_PETSC(VecGetArrayRead(s.x, &correction));
  for (int i = 0; i < s.tangent.n_unknowns(); ++i) {
    const auto dof = s.tangent.dof_of()[i];
    if (s.is_free[dof]) guess[dof] -= correction[i];
  }
  PHYNNESS_PETSC(VecRestoreArrayRead(s.x, &correction));
  return guess;
}

int Equilibrium::negative_pivots(std::span<const double> state) {
  auto& s = *_impl;
  // A tangent made convex has none, whatever the state.
  if (s.factors_are_convex)
    return linearize(state, Eigen::MatrixXd(s.constraint.n_parameters(), 0)).negative_pivots;
  return s.negative_pivots();
}

Eigen::VectorXd Equilibrium::force(std::span<const double> state) {
  auto& s = *_impl;
  s.state.assign(state.begin(), state.end());
  s.evaluate_residual();
  return s.reaction();
}

}  // namespace phynness
