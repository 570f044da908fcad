// Equilibrium under prescribed displacements: Newton's method of PETSc SNES with a line search on the free rows of the
// residual.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <span>
#include <vector>

#include "constraint.hpp"
#include "discretization.hpp"
#include "factorization.hpp"
#include "petsc_check.hpp"
#include "pressure_block.hpp"
#include "quasi_newton.hpp"
#include "tangent_matrix.hpp"

namespace phynness {

/// Solves r(x) = 0 in the free rows, which are neither fixed nor prescribed. Fixed and prescribed dofs keep their
/// values. Prescribed rows of the Newton system are those of the identity with the right-hand side zero, so that no
/// norm adds displacements and forces.
class Equilibrium {
 public:
  Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& options);
  Equilibrium(const Equilibrium&) = delete;  // callbacks refer to this object

  /// Sets the prescribed dofs of later solves. @pre none of them is fixed
  void prescribe(Constraint constraint);
  const Constraint& constraint() const { return _constraint; }

  struct Outcome {
    Status status = Status::converged;
    int iterations = 0;
    double relative_residual = 0;  ///< norm of the free rows over that of the reactions
    bool met_instability = false;  ///< some tangent of the solve had negative pivots
    bool has_left_saddle = false;  ///< the state has left an unstable equilibrium
    Eigen::VectorXd force;         ///< G^T r_c, n_parameters, if converged
  };
  /// Newton's method from `state`, whose prescribed dofs already have their values. After a failure `state` is
  /// unchanged. From an unstable equilibrium the method continues downhill along the direction of most negative
  /// curvature. A tangent that cannot be factorized is replaced by a convex one. A state is converged if |free rows of
  /// r|
  /// <= relative_tolerance * |reactions| in Euclidean norms, or if the residual is at the level of rounding.
  /// @param check_stability  checks the stability by another factorization even if no tangent of the solve had negative
  ///                         pivots
  Outcome solve(std::span<double> state, bool check_stability = false);

  /// The tangent at an equilibrium state, factorized.
  struct Linearization {
    Status status = Status::converged;  ///< factorization or converged
    int negative_pivots = 0;            ///< in excess of those of the pressure block
    Eigen::MatrixXd tangent;            ///< n_parameters^2: d(G^T r_c)/dq; symmetric
    Eigen::MatrixXd sensitivity;        ///< n_dofs x n_parameters: dx/dq
  };
  /// @param directions  n_parameters x k; tangent and sensitivity are multiplied by them and have k columns
  Linearization linearize(std::span<const double> state, const Eigen::MatrixXd& directions);

  /// The linear response to nodal forces, with the factors of the latest linearize().
  /// @param loads  n_dofs x k, dimensionless. @return n_dofs x k; empty if there are no factors
  Eigen::MatrixXd load_response(const Eigen::MatrixXd& loads);

  /// dx/dq times `direction` at the converged state of the last solve(), for predictors. One quasi-Newton correction of
  /// `guess` with the present factors costs a fifth of linearize().
  struct Velocity {
    Eigen::VectorXd rate;  ///< dx/ds, n_dofs
    /// d^2 energy / ds^2. Its error is of second order in the error of the guess, because it is stationary at the true
    /// rate.
    double stiffness = 0;
  };
  /// @param guess  n_dofs; its prescribed dofs are overwritten
  Velocity velocity(std::span<const double> state, const Eigen::VectorXd& direction, Eigen::VectorXd guess);

  /// Number of negative pivots of the last factorized tangent in excess of those of the pressure block. If that tangent
  /// was made convex, the true tangent at the converged state is factorized. Empty if there are no factors.
  std::optional<int> negative_pivots(std::span<const double> state);

  /// G^T r_c, n_parameters: the force that holds the prescribed displacement.
  Eigen::VectorXd force(std::span<const double> state);

  /// Must be called after an exception. Recreates all objects of libraries, because their state is unknown.
  void recover();
  /// False if recover() has thrown and must be called again.
  bool is_usable() const { return _is_usable; }

  /// See ProbeSolver::set_stop(). solve() and linearize() throw Interrupted.
  void set_stop(std::function<bool()> stop, double patience_s);

  SolverCounts counts() const { return _counts; }

 private:
  void set_up_solver();
  /// Runs a callback and stores its exception. @return an error code of PETSc
  template <typename Work>
  PetscErrorCode catch_exceptions(Work&& work) noexcept {
    try {
      work();
      return 0;
    } catch (...) {
      _callback_exception = std::current_exception();
      return PETSC_ERR_LIB;
    }
  }
  /// Whether a stop was requested longer than the patience ago.
  bool must_stop();
  /// Newton's method from `state`, which receives the result. @param from_convex  whether the first tangent is convex
  SNESConvergedReason iterate(bool from_convex, int most_iterations, int& iterations);
  /// Whether iterate() ended at or near an equilibrium that is not a minimum of the energy.
  /// @param check  whether the tangent of a converged state is factorized for this
  bool is_at_saddle(SNESConvergedReason reason, bool check);
  /// Moves `state` along the direction of most negative curvature while the energy decreases (leave_saddle.cpp).
  /// @return false if the energy does not decrease
  bool leave_saddle();
  /// Factorizes the true tangent at `state`. @return false if it has no factors
  bool factorize_exact();
  /// Adds a tiny reproducible perturbation to a step, so that rounding does not determine the direction of buckling.
  /// @return false if the factors give no finite solution
  bool break_symmetry(Vec step);
  /// LDL^T of the last assembled tangent. @return false if it cannot be factorized
  bool factorize();
  double rounding_residual();
  void evaluate_residual();
  double free_residual_norm() const;
  Convexity convexity() const {
    return !_convex ? Convexity::none : _needs_strict_convexity ? Convexity::strictly : Convexity::nearly;
  }
  /// The merit function of the line search at `state`: the stored energy with equilibrated pressures.
  /// @pre `residual` belongs to `state`
  double merit();
  /// G^T r_c of the latest residual.
  Eigen::VectorXd reaction() const { return _constraint.G.transpose() * dependent_values(_residual); }
  Eigen::VectorXd dependent_values(std::span<const double> values) const { return as_vector(values)(_constraint.dofs); }
  /// Stores G q of `state`.
  void store_prescribed();
  /// Sets `state` from the unknowns, with its dependent dofs; copies the unknowns of `state`; and copies the free rows
  /// of the condensed residual, with zeros in the other rows.
  void set_state(Vec from);
  void copy_unknowns(Vec to) const;
  void copy_residual(Vec to) const;
  /// The norm of the residual of a converged state.
  double residual_tolerance() const { return _options.relative_tolerance * _reaction_norm + _rounding_residual; }
  int negative_pivots();

  static PetscErrorCode form_function(SNES, Vec, Vec, void*);
  static PetscErrorCode form_jacobian(SNES, Vec, Mat, Mat, void*);
  static PetscErrorCode test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal, SNESConvergedReason*, void*);
  static PetscErrorCode set_up_factors(PC);
  static PetscErrorCode apply_factors(PC, Vec, Vec);
  /// The line search (newton_step.cpp).
  class Step;
  static PetscErrorCode step(SNESLineSearch, void*);

  Discretization& _body;
  SolverSpec _options;
  Factorization _factorization;
  TangentMatrix _tangent;
  Constraint _constraint;
  std::vector<char> _is_free;  ///< per dof: neither fixed nor dependent
  std::vector<double> _state, _residual;
  std::vector<double> _condensed;  ///< the residual with the rows of dependent dofs added to those of their masters
  Eigen::VectorXd _prescribed;     ///< G q of the solve
  double _reaction_norm = 0;       ///< of the latest residual
  double _rounding_residual = 0;   ///< norm of the residual that rounding causes
  SolverCounts _counts;
  PressureBlock _pressures;              ///< of the latest tangent
  QuasiNewton _quasi_newton;             ///< corrections since the latest factorization
  bool _needs_tangent = true;            ///< assemble and factorize in the next iteration
  bool _factors_are_current = false;     ///< the factors belong to the state from which the step starts
  bool _convex = false;                  ///< make element tangents positive semidefinite
  bool _needs_strict_convexity = false;  ///< nearly convex element tangents did not suffice in this solve
  bool _factors_are_convex = false;      ///< the latest factorization is of a convex tangent
  bool _is_usable = true;                ///< false during recover()
  PetscInt _most_iterations = 0;         ///< of Newton's method, including PETSC_OPTIONS
  bool _met_instability = false;         ///< a tangent of the latest solve had negative pivots
  bool _factorization_failed = false;    ///< in the latest solve there were no factors, or no finite solution
  std::function<bool()> _stop;           ///< says that the user wants an end
  double _patience_s = 0;                ///< a solve may go on for so long
  std::optional<std::chrono::steady_clock::time_point> _stop_requested_at;
  std::exception_ptr _callback_exception;  ///< exception of a callback, because exceptions must not pass through PETSc
  PetscVec _x, _r;
  PetscSnes _snes;
};

}  // namespace phynness
