// Equilibrium under prescribed displacements: Newton's method of PETSc SNES with a line search on the free rows of the
// residual.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
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

/// Solves r(x) = load in the free rows, which are neither fixed nor prescribed. Fixed and prescribed dofs keep the
/// values that they have in the state before a solve. Prescribed rows of the Newton system are those of the identity
/// with the right-hand side zero, so that displacements and forces are never added in a norm.
class Equilibrium {
 public:
  Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& options);
  Equilibrium(const Equilibrium&) = delete;  // callbacks refer to this object

  /// Sets the prescribed dofs of later solves. @pre none of them is fixed
  void prescribe(Constraint constraint);
  const Constraint& constraint() const { return _constraint; }
  /// Sets a dead load: nodal forces, n_dofs, dimensionless.
  void set_load(std::vector<double> load);

  struct Outcome {
    Status status = Status::converged;
    int iterations = 0;
    double relative_residual = 0;  ///< |free rows| / |reactions|
    bool met_instability = false;  ///< a tangent during the solve had negative pivots
    bool left_saddle = false;      ///< Newton's method first found an unstable equilibrium, and the state has left it
    Eigen::VectorXd force;         ///< G^T r_c, n_parameters, if converged
  };
  /// Newton's method from `state`, whose prescribed dofs already have their values. After a failure `state` is
  /// unchanged. From an unstable equilibrium the method continues downhill along the direction of most negative
  /// curvature. A tangent that cannot be factorized is replaced by a convex one. Converged means |free rows of r -
  /// load| <= relative_tolerance * (|reactions| + |load|) in Euclidean norms, or a residual at the level of rounding,
  /// which occurs for tiny displacements.
  /// @param check_stability  check the stability of the equilibrium even if no tangent during the solve had negative
  ///                         pivots, which takes another factorization
  Outcome solve(std::span<double> state, bool check_stability = false);

  /// The tangent at an equilibrium state, factorized.
  struct Linearization {
    Status status = Status::converged;  ///< factorization or converged
    int negative_pivots = 0;            ///< beyond those of the pressure block
    Eigen::MatrixXd tangent;            ///< n_parameters^2: d(G^T r_c)/dq; symmetric
    Eigen::MatrixXd sensitivity;        ///< n_dofs x n_parameters: dx/dq
  };
  /// @param directions  n_parameters x k: only the product of dx/dq with these is computed, so that tangent and
  ///                    sensitivity have k columns
  Linearization linearize(std::span<const double> state, const Eigen::MatrixXd& directions);

  /// The change of the state under nodal forces, at the state of the latest linearize(), whose factors are used.
  /// @param loads  n_dofs x k, dimensionless. @return n_dofs x k; empty if there are no factors
  Eigen::MatrixXd change_under(const Eigen::MatrixXd& loads);

  /// dx/dq times `direction` at the converged state of the last solve(), for predictors. It is computed by one
  /// quasi-Newton correction of `guess` with the present factors, at a fifth of the cost of linearize().
  struct Velocity {
    Eigen::VectorXd rate;  ///< dx/ds, n_dofs
    /// d^2 energy / ds^2, from the residuals that the correction needs anyway. Its error is of second order in the
    /// error of the guess, because the true rate makes this number stationary.
    double stiffness = 0;
  };
  /// @param guess  n_dofs; its prescribed dofs are overwritten
  Velocity velocity(std::span<const double> state, const Eigen::VectorXd& direction, Eigen::VectorXd guess);

  /// Number of negative pivots beyond those of the pressure block, from the last tangent that solve() factorized. If
  /// that tangent was made convex, the true tangent at the converged state is factorized. Empty if it has no factors.
  std::optional<int> negative_pivots(std::span<const double> state);

  /// G^T r_c, n_parameters: the force that must be applied to hold the prescribed displacement.
  Eigen::VectorXd force(std::span<const double> state);

  /// Must be called after an exception: recreates all objects of libraries, whose state is then unknown.
  void recover();
  /// False after a recover() that threw; recover() must then be called again.
  bool is_usable() const { return _usable; }

  /// See ProbeSolver::set_stop(). solve() and linearize() then throw Interrupted.
  void set_stop(std::function<bool()> stop, double patience_s);

  SolverCounts counts() const { return _counts; }

 private:
  void set_up_solver();
  /// Runs a callback and catches its exceptions. @return an error code of PETSc
  template <typename Work>
  PetscErrorCode contain(Work&& work) noexcept {
    try {
      work();
      return 0;
    } catch (...) {
      _trouble = std::current_exception();
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
  Convexity convexity() const {
    return !_convex ? Convexity::none : _strictly ? Convexity::strictly : Convexity::nearly;
  }
  /// Energy at `state` minus the work of the load.
  double energy_and_load();
  /// The function that steps decrease, at `state`: the stored energy with pressures in equilibrium with the
  /// displacements.
  /// @pre `residual` belongs to `state`
  double merit();
  /// G^T r_c of the latest residual.
  Eigen::VectorXd reaction() const { return _constraint.G.transpose() * at_dependent(_residual); }
  Eigen::VectorXd at_dependent(std::span<const double> values) const { return as_vector(values)(_constraint.dofs); }
  /// Keeps G q of `state` as `held`.
  void hold();
  /// Copies unknowns to `state`, with the dependent dofs that belong to them, and back; the condensed residual's free
  /// rows, with zeros in the other rows.
  void gather(Vec from);
  void spread(Vec to) const;
  void scatter(Vec to) const;
  /// Norm of the residual at which a state is converged.
  double goal() const { return _options.relative_tolerance * (_reaction_norm + _load_norm) + _rounding; }
  int negative_pivots();

  static PetscErrorCode form_function(SNES, Vec, Vec, void*);
  static PetscErrorCode form_jacobian(SNES, Vec, Mat, Mat, void*);
  static PetscErrorCode test_convergence(SNES, PetscInt, PetscReal, PetscReal, PetscReal, SNESConvergedReason*, void*);
  static PetscErrorCode set_up_factors(PC);
  static PetscErrorCode apply_factors(PC, Vec, Vec);
  /// A step along the direction that SNES has computed (newton_step.cpp).
  class Step;
  static PetscErrorCode step(SNESLineSearch, void*);

  Discretization& _body;
  SolverSpec _options;
  Factorization _linear;
  TangentMatrix _tangent;
  Constraint _constraint;
  std::vector<char> _is_free;  ///< per dof: neither fixed nor dependent
  std::vector<double> _load, _state, _residual;
  std::vector<double> _condensed;  ///< the residual with the rows of dependent dofs added to those of their masters
  Eigen::VectorXd _held;           ///< G q of the solve
  double _reaction_norm = 0, _load_norm = 0;  ///< of the latest residual
  double _rounding = 0;                       ///< norm of a residual that is caused by rounding
  SolverCounts _counts;
  PressureBlock _pressures;          ///< of the latest tangent
  QuasiNewton _quasi_newton;         ///< corrections since the latest factorization
  bool _refresh = true;              ///< assemble and factorize in the next iteration
  bool _fresh = false;               ///< the factors belong to the state from which the step starts
  bool _convex = false;              ///< make element tangents positive semidefinite
  bool _strictly = false;            ///< in this solve, nearly convex element tangents did not suffice
  bool _factors_are_convex = false;  ///< the latest factorization is of a convex tangent
  bool _usable = true;               ///< false during recover()
  PetscInt _most_iterations = 0;     ///< of Newton's method, including PETSC_OPTIONS
  bool _met_instability = false;     ///< a tangent of the latest solve had negative pivots
  bool _linear_failed = false;       ///< in the latest solve there were no factors, or no finite solution
  std::function<bool()> _stop;       ///< says that the user wants an end
  double _patience_s = 0;            ///< a solve may go on for so long
  std::optional<std::chrono::steady_clock::time_point> _asked_to_end;
  std::exception_ptr _trouble;  ///< exception of a callback, because exceptions must not pass through PETSc
  PetscVec _x, _r;
  PetscSnes _snes;
};

}  // namespace phynness
