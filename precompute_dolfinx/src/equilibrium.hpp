// Equilibrium under prescribed displacements: Newton's method of PETSc SNES with a line search on the free rows of the
// residual.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <span>
#include <vector>

#include "constraint.hpp"
#include "discretization.hpp"
#include "linear_solver.hpp"

namespace phynness {

/// Solves r(x) = load in the free rows, which are neither fixed nor prescribed. Fixed and prescribed dofs keep the
/// values that they have in the state before a solve. Prescribed rows of the Newton system are those of the identity
/// with the right-hand side zero, so that displacements and forces are never added in a norm.
class Equilibrium {
 public:
  /// @param shared  solver that factorizes together with other ranks; null: this process factorizes alone
  Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& options,
              LinearSolver* shared = nullptr);
  ~Equilibrium();
  Equilibrium(Equilibrium&&) noexcept;

  /// Sets the prescribed dofs of later solves. @pre none of them is fixed
  void prescribe(Constraint constraint);
  const Constraint& constraint() const;
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
  bool is_usable() const;

  /// See ProbeSolver::set_stop(). solve() and linearize() then throw Interrupted.
  void set_stop(std::function<bool()> stop, double patience_s);

  SolverCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness
