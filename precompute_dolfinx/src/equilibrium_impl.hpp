// What Equilibrium keeps between calls, and the callbacks that PETSc makes.
#pragma once

#include "equilibrium.hpp"
#include "petsc_check.hpp"
#include "pressure_block.hpp"
#include "quasi_newton.hpp"
#include "tangent_matrix.hpp"
#include "team.hpp"

namespace phynness {

struct Equilibrium::Impl {
  Impl(Discretization& discretization, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& spec,
       Team* helpers);

  Discretization& body;
  SolverSpec options;
  Team* team;  ///< that factorizes; null: this process alone
  TangentMatrix tangent;
  Constraint constraint;
  std::vector<std::int32_t> prescribed;  ///< unknowns of constraint.dofs
  std::vector<char> is_free;             ///< per dof: neither fixed nor prescribed
  std::vector<double> load, state, residual;
  double reaction_norm = 0, load_norm = 0;  ///< of the latest residual
  double rounding = 0;                      ///< a residual of this norm cannot be told from zero
  SolverCounts counts;
  PressureBlock pressures;          ///< of the latest tangent
  QuasiNewton quasi_newton;         ///< since the latest factorization
  bool refresh = true;              ///< assemble and factorize at the next iteration
  bool fresh = false;               ///< the factors are those of the state that the step starts from
  bool convex = false;              ///< factorize element tangents made positive semidefinite
  bool factors_are_convex = false;  ///< what the latest factorization was of
  PetscVec x, r;
  PetscSnes snes;

  void set_up_solver();
  double residual_of_rounding();
  void evaluate_residual();
  double free_norm() const;
  /// G^T r_c of the latest residual.
  Eigen::VectorXd reaction() const;
  /// Unknowns into `state` and out of it; the residual's free rows, zero elsewhere.
  void gather(Vec from);
  void spread(Vec to) const;
  void scatter(Vec to) const;
  /// A residual of this norm is converged.
  double goal() const { return options.relative_tolerance * (reaction_norm + load_norm) + rounding; }
  int negative_pivots() const;

  static PetscErrorCode form_function(SNES, Vec, Vec, void*);
  static PetscErrorCode form_jacobian(SNES, Vec, Mat, Mat, void*);
  static PetscErrorCode test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal,
                                         SNESConvergedReason*, void*);
  static PetscErrorCode factorize_together(PC);
  static PetscErrorCode solve_together(PC, Vec, Vec);
  /// One step along the direction that SNES has computed (newton_step.cpp).
  static PetscErrorCode step(SNESLineSearch, void*);
};

}  // namespace phynness
