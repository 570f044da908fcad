// State of a solve, and the callbacks from PETSc.
#include "equilibrium_impl.hpp"

#include <cmath>
#include <limits>

#include "linear_solver.hpp"

namespace phynness {

std::vector<std::int32_t> unknowns_of(const TangentMatrix& tangent, std::span<const std::int32_t> dofs) {
  std::vector<std::int32_t> unknowns;
  for (const auto dof : dofs) unknowns.push_back(tangent.unknown_of()[dof]);
  return unknowns;
}

Equilibrium::Impl::Impl(Discretization& discretization, const std::vector<std::int32_t>& fixed_dofs,
                        const SolverSpec& spec, LinearSolver* shared)
    : body(discretization),
      options(spec),
      own(shared ? nullptr : serial_factorization()),
      linear(shared ? shared : own.get()),
      tangent(discretization, fixed_dofs),
      pressures(unknowns_of(tangent, discretization.pressure_dofs())) {
  set_up_solver();
  rounding = residual_of_rounding();
}

int Equilibrium::Impl::negative_pivots() {
  return linear->negative_pivots() - static_cast<int>(body.pressure_dofs().size());
}

bool Equilibrium::Impl::factorize() {
  ++counts.factorizations;
  return tangent.is_finite() && linear->factorize(tangent.matrix());
}

PetscErrorCode Equilibrium::Impl::set_up_factors(PC pc) {
  void* context = nullptr;
  PetscCall(PCShellGetContext(pc, &context));
  auto& self = *static_cast<Impl*>(context);
  return self.contain([&] {
    self.linear_failed = !self.factorize();
    PHYNNESS_PETSC(PCSetFailedReason(pc, self.linear_failed ? PC_FACTOR_NUMERIC_ZEROPIVOT : PC_NOERROR));
  });
}

PetscErrorCode Equilibrium::Impl::apply_factors(PC pc, Vec b, Vec x) {
  void* context = nullptr;
  PetscCall(PCShellGetContext(pc, &context));
  auto& self = *static_cast<Impl*>(context);
  return self.contain([&] {
    if (self.linear->solve(b, x)) return;
    self.linear_failed = true;
    PHYNNESS_PETSC(PCSetFailedReason(pc, PC_FACTOR_OTHER));
  });
}

void Equilibrium::Impl::set_up_solver() {
  state.assign(body.n_dofs(), 0.0);
  residual.assign(body.n_dofs(), 0.0);
  condensed = residual;
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
  PHYNNESS_PETSC(KSPSetOperators(ksp, tangent.matrix(), tangent.matrix()));
  PHYNNESS_PETSC(PCSetType(pc, PCSHELL));
  PHYNNESS_PETSC(PCShellSetContext(pc, this));
  PHYNNESS_PETSC(PCShellSetSetUp(pc, set_up_factors));
  PHYNNESS_PETSC(PCShellSetApply(pc, apply_factors));
  PHYNNESS_PETSC(SNESSetFromOptions(snes));
  PHYNNESS_PETSC(SNESGetTolerances(snes, nullptr, nullptr, nullptr, &most_iterations, nullptr));
}

/// Norm of the residual that rounding causes: the rounding of F = I + grad u has the same effect as an error of every
/// point of 1e-16 of the body's size. Without this lower bound a displacement of a millionth of the body could not meet
/// a tolerance that is relative to its small forces.
double Equilibrium::Impl::residual_of_rounding() {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(body.n_dofs());
  body.block_tangents(std::vector<double>(body.n_dofs(), 0.0), Convexity::none,
                      [&](std::int32_t block, std::span<const double> tangent, std::span<const double>) {
                        const auto dofs = body.block_dofs(block);
                        for (std::size_t i = 0; i < dofs.size(); ++i)
                          diagonal[dofs[i]] += tangent[i * (dofs.size() + 1)];
                      });
  const Eigen::RowVector3d extent = body.points().colwise().maxCoeff() - body.points().colwise().minCoeff();
  return std::numeric_limits<double>::epsilon() / 2 * diagonal.norm() * extent.norm();
}

void Equilibrium::Impl::gather(Vec from) {
  const ReadValues values(from);
  for (int i = 0; i < tangent.n_unknowns(); ++i) state[tangent.dof_of()[i]] = values[i];
  constraint.complete(state, held);
}

void Equilibrium::Impl::hold() { held = -constraint.dependent(state, -at_dependent(state)); }

void Equilibrium::Impl::spread(Vec to) const {
  const WriteValues values(to);
  for (int i = 0; i < tangent.n_unknowns(); ++i) values[i] = state[tangent.dof_of()[i]];
}

void Equilibrium::Impl::scatter(Vec to) const {
  const WriteValues out(to);
  for (int i = 0; i < tangent.n_unknowns(); ++i) {
    const auto dof = tangent.dof_of()[i];
    out[i] = is_free[dof] ? condensed[dof] : 0.0;
  }
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
  condensed = residual;
  constraint.condense(condensed);
}

Eigen::VectorXd Equilibrium::Impl::at_dependent(std::span<const double> values) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(constraint.dofs.size()));
  for (std::size_t i = 0; i < constraint.dofs.size(); ++i)
    out[static_cast<Eigen::Index>(i)] = values[constraint.dofs[i]];
  return out;
}

double Equilibrium::Impl::free_norm() const {
  double sum = 0;
  for (int dof = 0; dof < body.n_dofs(); ++dof)
    if (is_free[dof]) sum += condensed[dof] * condensed[dof];
  return std::sqrt(sum);
}

double Equilibrium::Impl::energy_and_load() {
  double energy = body.energy(state);
  for (std::size_t dof = 0; dof < load.size(); ++dof) energy -= load[dof] * state[dof];
  return energy;
}

double Equilibrium::Impl::merit() {
  const double energy = energy_and_load();
  if (pressures.empty()) return energy;
  const auto& dofs = body.pressure_dofs();
  Eigen::VectorXd r_p(static_cast<Eigen::Index>(dofs.size()));
  for (std::size_t i = 0; i < dofs.size(); ++i) r_p[static_cast<Eigen::Index>(i)] = residual[dofs[i]];
  return energy + r_p.dot(pressures.solve(r_p)) / 2;
}

PetscErrorCode Equilibrium::Impl::form_function(SNES snes, Vec x, Vec r, void* context) {
  auto& self = *static_cast<Impl*>(context);
  return self.contain([&] {
    self.gather(x);
    self.evaluate_residual();
    self.scatter(r);
    // ln J gives NaN for J <= 0; a domain error makes the line search use a shorter step.
    if (!std::isfinite(self.free_norm())) PHYNNESS_PETSC(SNESSetFunctionDomainError(snes));
  });
}

PetscErrorCode Equilibrium::Impl::form_jacobian(SNES snes, Vec x, Mat, Mat, void* context) {
  auto& self = *static_cast<Impl*>(context);
  return self.contain([&] {
    KSP ksp;
    PHYNNESS_PETSC(SNESGetKSP(snes, &ksp));
    PHYNNESS_PETSC(KSPSetReusePreconditioner(ksp, self.refresh ? PETSC_FALSE : PETSC_TRUE));
    ++self.counts.substitutions;
    self.fresh = self.refresh;
    if (!self.refresh) return;
    self.refresh = false;
    self.quasi_newton.clear();
    self.gather(x);
    self.tangent.assemble(self.body, self.state, self.convexity());
    self.pressures.set(self.tangent.matrix());
    self.factors_are_convex = self.convex;
    ++self.counts.tangents;
  });
}

PetscErrorCode Equilibrium::Impl::test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal norm,
                                                   SNESConvergedReason* reason, void* context) {
  auto& self = *static_cast<Impl*>(context);
  return self.contain([&] {
    *reason = SNES_CONVERGED_ITERATING;
    if (!std::isfinite(norm))
      *reason = SNES_DIVERGED_FUNCTION_NANORINF;
    else if (norm <= self.goal())
      *reason = SNES_CONVERGED_FNORM_RELATIVE;
    else if (self.must_end())
      *reason = SNES_DIVERGED_FUNCTION_COUNT;  // iterate() then says why
  });
}

}  // namespace phynness
