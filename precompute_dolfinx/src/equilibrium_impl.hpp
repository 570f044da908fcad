// State of Equilibrium between calls, and the callbacks from PETSc.
#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <span>

#include "equilibrium.hpp"
#include "linear_solver.hpp"
#include "petsc_check.hpp"
#include "pressure_block.hpp"
#include "quasi_newton.hpp"
#include "tangent_matrix.hpp"

namespace phynness {

/// Numbers of the unknowns that belong to these dofs.
std::vector<std::int32_t> unknowns_of(const TangentMatrix& tangent, std::span<const std::int32_t> dofs);

struct Equilibrium::Impl {
  Impl(Discretization& discretization, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& spec,
       LinearSolver* shared);

  Discretization& body;
  SolverSpec options;
  std::unique_ptr<LinearSolver> own;  ///< null if a team factorizes
  LinearSolver* linear;               ///< the solver in use
  TangentMatrix tangent;
  Constraint constraint;
  std::vector<char> is_free;  ///< per dof: neither fixed nor dependent
  std::vector<double> load, state, residual;
  std::vector<double> condensed;  ///< the residual with the rows of dependent dofs added to those of their masters
  Eigen::VectorXd held;           ///< G q of the solve
  double reaction_norm = 0, load_norm = 0;  ///< of the latest residual
  double rounding = 0;                      ///< norm of a residual that is caused by rounding
  SolverCounts counts;
  PressureBlock pressures;          ///< of the latest tangent
  QuasiNewton quasi_newton;         ///< corrections since the latest factorization
  bool refresh = true;              ///< assemble and factorize in the next iteration
  bool fresh = false;               ///< the factors belong to the state from which the step starts
  bool convex = false;              ///< make element tangents positive semidefinite
  bool strictly = false;            ///< in this solve, nearly convex element tangents did not suffice
  bool factors_are_convex = false;  ///< the latest factorization is of a convex tangent
  bool usable = true;               ///< false during recover()
  PetscInt most_iterations = 0;     ///< of Newton's method, including PETSC_OPTIONS
  bool met_instability = false;     ///< a tangent of the latest solve had negative pivots
  bool linear_failed = false;       ///< in the latest solve there were no factors, or no finite solution
  std::function<bool()> stop;       ///< says that the user wants an end
  double patience_s = 0;            ///< a solve may go on for so long
  std::optional<std::chrono::steady_clock::time_point> asked_to_end;
  std::exception_ptr trouble;  ///< exception of a callback, because exceptions must not pass through PETSc
  PetscVec x, r;
  PetscSnes snes;

  void set_up_solver();
  /// Runs a callback and catches its exceptions. @return an error code of PETSc
  template <typename Work>
  PetscErrorCode contain(Work&& work) noexcept {
    try {
      work();
      return 0;
    } catch (...) {
      trouble = std::current_exception();
      return PETSC_ERR_LIB;
    }
  }
  /// Whether the user has waited long enough for an end.
  bool must_end();
  /// Newton's method from `state`, which receives the result. @param from_convex  make the first tangent convex
  SNESConvergedReason iterate(bool from_convex, int most_iterations, int& iterations);
  /// Whether iterate() ended at or near an equilibrium that is not a minimum of the energy.
  /// @param check  factorize the tangent of a converged state to check this
  bool stays_at_saddle(SNESConvergedReason reason, bool check);
  /// Moves `state` along the direction of most negative curvature as far as the energy decreases (leave_saddle.cpp).
  /// @return false if it does not decrease
  bool leave_saddle();
  /// Factorizes the true tangent at `state`. @return false if it has no factors
  bool factorize_exact();
  /// Adds a tiny vector to a step, which only matters where rounding would otherwise determine the direction of
  /// buckling.
  /// @return false if the factors give no finite solution
  bool break_symmetry(Vec step);
  /// LDL^T of the last assembled tangent. @return false if it cannot be factorized
  bool factorize();
  double residual_of_rounding();
  void evaluate_residual();
  double free_norm() const;
  Convexity convexity() const { return !convex ? Convexity::none : strictly ? Convexity::strictly : Convexity::nearly; }
  /// Energy at `state` minus the work of the load.
  double energy_and_load();
  /// The function that steps decrease, at `state`: the stored energy with pressures in equilibrium with the
  /// displacements.
  /// @pre `residual` belongs to `state`
  double merit();
  /// G^T r_c of the latest residual.
  Eigen::VectorXd reaction() const { return constraint.G.transpose() * at_dependent(residual); }
  Eigen::VectorXd at_dependent(std::span<const double> values) const;
  /// Keeps G q of `state` as `held`.
  void hold();
  /// Copies unknowns to `state`, with the dependent dofs that belong to them, and back; the condensed residual's free
  /// rows, with zeros in the other rows.
  void gather(Vec from);
  void spread(Vec to) const;
  void scatter(Vec to) const;
  /// Norm of the residual at which a state is converged.
  double goal() const { return options.relative_tolerance * (reaction_norm + load_norm) + rounding; }
  int negative_pivots();

  static PetscErrorCode form_function(SNES, Vec, Vec, void*);
  static PetscErrorCode form_jacobian(SNES, Vec, Mat, Mat, void*);
  static PetscErrorCode test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal, SNESConvergedReason*, void*);
  static PetscErrorCode set_up_factors(PC);
  static PetscErrorCode apply_factors(PC, Vec, Vec);
  /// One step along the direction that SNES has computed (newton_step.cpp).
  static PetscErrorCode step(SNESLineSearch, void*);
};

}  // namespace phynness
