// Residual, tangent and merit function of the iterations, and the callbacks of PETSc.
#include <cmath>
#include <limits>

#include "equilibrium.hpp"

namespace phynness {

int Equilibrium::negative_pivots() {
  return _factorization.negative_pivots() - static_cast<int>(_body.pressure_dofs().size());
}

bool Equilibrium::factorize() {
  ++_counts.factorizations;
  return _tangent.is_finite() && _factorization.factorize(_tangent.matrix());
}

PetscErrorCode Equilibrium::set_up_factors(PC pc) {
  void* context = nullptr;
  PetscCall(PCShellGetContext(pc, &context));
  auto& self = *static_cast<Equilibrium*>(context);
  return self.catch_exceptions([&] {
    self._factorization_failed = !self.factorize();
    PHYNNESS_PETSC(PCSetFailedReason(pc, self._factorization_failed ? PC_FACTOR_NUMERIC_ZEROPIVOT : PC_NOERROR));
  });
}

PetscErrorCode Equilibrium::apply_factors(PC pc, Vec b, Vec x) {
  void* context = nullptr;
  PetscCall(PCShellGetContext(pc, &context));
  auto& self = *static_cast<Equilibrium*>(context);
  return self.catch_exceptions([&] {
    if (self._factorization.solve(b, x)) return;
    self._factorization_failed = true;
    PHYNNESS_PETSC(PCSetFailedReason(pc, PC_FACTOR_OTHER));
  });
}

void Equilibrium::set_up_solver() {
  _state.assign(_body.n_dofs(), 0.0);
  _residual.assign(_body.n_dofs(), 0.0);
  _condensed = _residual;
  const auto n = static_cast<PetscInt>(_tangent.n_unknowns());
  PHYNNESS_PETSC(VecCreateSeq(PETSC_COMM_SELF, n, _x.address()));
  PHYNNESS_PETSC(VecDuplicate(_x, _r.address()));
  PHYNNESS_PETSC(SNESCreate(PETSC_COMM_SELF, _snes.address()));
  PHYNNESS_PETSC(SNESSetOptionsPrefix(_snes, "phynness_"));
  PHYNNESS_PETSC(SNESSetFunction(_snes, _r, form_function, this));
  PHYNNESS_PETSC(SNESSetJacobian(_snes, _tangent.matrix(), _tangent.matrix(), form_jacobian, this));
  PHYNNESS_PETSC(SNESSetConvergenceTest(_snes, test_convergence, this, nullptr));
  PHYNNESS_PETSC(SNESSetTolerances(_snes, 0, 0, 0, _options.max_iterations, 100 * _options.max_iterations));
  KSP ksp;
  PC pc;
  PHYNNESS_PETSC(SNESGetKSP(_snes, &ksp));
  PHYNNESS_PETSC(KSPSetType(ksp, KSPPREONLY));
  PHYNNESS_PETSC(KSPGetPC(ksp, &pc));
  SNESLineSearch search;
  PHYNNESS_PETSC(SNESGetLineSearch(_snes, &search));
  PHYNNESS_PETSC(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  PHYNNESS_PETSC(SNESLineSearchShellSetApply(search, step, this));
  PHYNNESS_PETSC(KSPSetOperators(ksp, _tangent.matrix(), _tangent.matrix()));
  PHYNNESS_PETSC(PCSetType(pc, PCSHELL));
  PHYNNESS_PETSC(PCShellSetContext(pc, this));
  PHYNNESS_PETSC(PCShellSetSetUp(pc, set_up_factors));
  PHYNNESS_PETSC(PCShellSetApply(pc, apply_factors));
  PHYNNESS_PETSC(SNESSetFromOptions(_snes));
  PHYNNESS_PETSC(SNESGetTolerances(_snes, nullptr, nullptr, nullptr, &_most_iterations, nullptr));
}

/// Norm of the residual that rounding causes: the rounding of F = I + grad u has the same effect as an error of every
/// point of 1e-16 of the body's size. Without this lower bound a displacement of a millionth of the body could not meet
/// a tolerance that is relative to its small forces.
double Equilibrium::rounding_residual() {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(_body.n_dofs());
  _body.block_tangents(std::vector<double>(_body.n_dofs(), 0.0), Convexity::none,
                       [&](std::int32_t block, std::span<const double> tangent, std::span<const double>) {
                         const auto dofs = _body.block_dofs(block);
                         for (std::size_t i = 0; i < dofs.size(); ++i)
                           diagonal[dofs[i]] += tangent[i * (dofs.size() + 1)];
                       });
  const Eigen::RowVector3d extent = _body.points().colwise().maxCoeff() - _body.points().colwise().minCoeff();
  return std::numeric_limits<double>::epsilon() / 2 * diagonal.norm() * extent.norm();
}

void Equilibrium::set_state(Vec from) {
  const ReadValues values(from);
  for (int i = 0; i < _tangent.n_unknowns(); ++i) _state[_tangent.dof_of()[i]] = values[i];
  _constraint.complete(_state, _prescribed);
}

void Equilibrium::store_prescribed() { _prescribed = -_constraint.dependent(_state, -dependent_values(_state)); }

void Equilibrium::copy_unknowns(Vec to) const {
  const WriteValues values(to);
  for (int i = 0; i < _tangent.n_unknowns(); ++i) values[i] = _state[_tangent.dof_of()[i]];
}

void Equilibrium::copy_residual(Vec to) const {
  const WriteValues out(to);
  for (int i = 0; i < _tangent.n_unknowns(); ++i) {
    const auto dof = _tangent.dof_of()[i];
    out[i] = _is_free[dof] ? _condensed[dof] : 0.0;
  }
}

void Equilibrium::evaluate_residual() {
  _body.residual(_state, _residual);
  ++_counts.residuals;
  double reactions = 0;
  for (int dof = 0; dof < _body.n_dofs(); ++dof)
    if (!_is_free[dof]) reactions += _residual[dof] * _residual[dof];
  _reaction_norm = std::sqrt(reactions);
  _condensed = _residual;
  _constraint.condense(_condensed);
}

double Equilibrium::free_residual_norm() const {
  double sum = 0;
  for (int dof = 0; dof < _body.n_dofs(); ++dof)
    if (_is_free[dof]) sum += _condensed[dof] * _condensed[dof];
  return std::sqrt(sum);
}

double Equilibrium::merit() {
  const double energy = _body.energy(_state);
  if (_pressures.empty()) return energy;
  const Eigen::VectorXd r_p = as_vector(_residual)(_body.pressure_dofs());
  return energy + r_p.dot(_pressures.solve(r_p)) / 2;
}

PetscErrorCode Equilibrium::form_function(SNES snes, Vec x, Vec r, void* context) {
  auto& self = *static_cast<Equilibrium*>(context);
  return self.catch_exceptions([&] {
    self.set_state(x);
    self.evaluate_residual();
    self.copy_residual(r);
    // ln J gives NaN for J <= 0; a domain error makes the line search use a shorter step.
    if (!std::isfinite(self.free_residual_norm())) PHYNNESS_PETSC(SNESSetFunctionDomainError(snes));
  });
}

PetscErrorCode Equilibrium::form_jacobian(SNES snes, Vec x, Mat, Mat, void* context) {
  auto& self = *static_cast<Equilibrium*>(context);
  return self.catch_exceptions([&] {
    KSP ksp;
    PHYNNESS_PETSC(SNESGetKSP(snes, &ksp));
    PHYNNESS_PETSC(KSPSetReusePreconditioner(ksp, self._needs_tangent ? PETSC_FALSE : PETSC_TRUE));
    ++self._counts.substitutions;
    self._factors_are_current = self._needs_tangent;
    if (!self._needs_tangent) return;
    self._needs_tangent = false;
    self._quasi_newton.clear();
    self.set_state(x);
    self._tangent.assemble(self._body, self._state, self.convexity());
    self._pressures.copy_from(self._tangent.matrix());
    self._factors_are_convex = self._convex;
    ++self._counts.tangents;
  });
}

PetscErrorCode Equilibrium::test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal norm,
                                             SNESConvergedReason* reason, void* context) {
  auto& self = *static_cast<Equilibrium*>(context);
  return self.catch_exceptions([&] {
    *reason = SNES_CONVERGED_ITERATING;
    if (!std::isfinite(norm))
      *reason = SNES_DIVERGED_FUNCTION_NANORINF;
    else if (norm <= self.residual_tolerance())
      *reason = SNES_CONVERGED_FNORM_RELATIVE;
    else if (self.must_stop())
      *reason = SNES_DIVERGED_FUNCTION_COUNT;  // iterate() then throws Interrupted
  });
}

}  // namespace phynness
