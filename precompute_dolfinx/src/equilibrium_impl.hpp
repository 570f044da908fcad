// What Equilibrium keeps between calls, and the callbacks that PETSc makes.
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

/// Numbers of these dofs among the unknowns.
std::vector<std::int32_t> unknowns_of(const TangentMatrix& tangent, std::span<const std::int32_t> dofs);

struct Equilibrium::Impl {
  Impl(Discretization& discretization, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& spec,
       LinearSolver* shared);

  Discretization& body;
  SolverSpec options;
  std::unique_ptr<LinearSolver> own;  ///< null where others help
  LinearSolver* linear;               ///< that factorizes
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
  bool strictly = false;            ///< in this solve, nearly convex ones were not enough
  bool factors_are_convex = false;  ///< what the latest factorization was of
  bool usable = true;               ///< false while recover() is at work
  PetscInt most_iterations = 0;     ///< of Newton's method, after PETSC_OPTIONS had their say
  bool met_instability = false;     ///< a tangent with negative pivots, in the latest solve
  bool linear_failed = false;       ///< no factors, or no finite answer by them, in the latest solve
  std::function<bool()> stop;       ///< says that a person wants an end
  std::optional<std::chrono::steady_clock::time_point> asked_to_end;
  std::exception_ptr trouble;  ///< what a callback met: no exception may pass through PETSc
  PetscVec x, r;
  PetscSnes snes;

  void set_up_solver();
  /// Runs what PETSc calls back for. @return PETSc's error code
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
  /// Whether a person has waited long enough for an end.
  bool must_end();
  /// Newton's method from `state` to where it ends, in `state`. @param from_convex  the first tangent is made
  /// convex
  SNESConvergedReason iterate(bool from_convex, int most_iterations, int& iterations);
  /// Whether iterate() ended at, or next to, an equilibrium that is no minimum of the energy.
  /// @param check  factorize the tangent of a converged state to see
  bool stays_at_saddle(SNESConvergedReason reason, bool check);
  /// Moves `state` along the direction of most negative curvature, as far as the energy falls
  /// (leave_saddle.cpp). @return false if it falls nowhere
  bool leave_saddle();
  /// Factorizes the true tangent at `state`. @return false if it has no factors
  bool factorize_exact();
  /// Adds to a step so little that it matters only where rounding would decide which way a body buckles.
  /// @return false if the factors have no finite answer
  bool break_symmetry(Vec step);
  /// LDL^T of the tangent as it was assembled last. @return false if it has none
  bool factorize();
  double residual_of_rounding();
  void evaluate_residual();
  double free_norm() const;
  Convexity convexity() const { return !convex ? Convexity::none : strictly ? Convexity::strictly : Convexity::nearly; }
  /// At `state`, without the load's share of the work.
  double energy_and_load();
  /// What steps descend, at `state`, of which `residual` is: the stored energy, with the pressures that the
  /// displacements ask for.
  double merit();
  /// G^T r_c of the latest residual.
  Eigen::VectorXd reaction() const;
  /// Unknowns into `state` and out of it; the residual's free rows, zero elsewhere.
  void gather(Vec from);
  void spread(Vec to) const;
  void scatter(Vec to) const;
  /// A residual of this norm is converged.
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
