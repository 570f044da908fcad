// Equilibrium under prescribed displacements, by PETSc SNES: Newton with line search on the free rows of the
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

/// Solves r(x) = load on the rows that are neither fixed nor prescribed. Fixed dofs keep the value they have
/// in the state; prescribed dofs keep theirs during a solve: they are put there first, their rows of the
/// Newton system are the identity with right-hand side zero, so no metre ever meets a newton in a norm.
class Equilibrium {
 public:
  /// @param shared  factorizes together with other ranks; null: this process alone
  Equilibrium(Discretization& body, const std::vector<std::int32_t>& fixed_dofs, const SolverSpec& options,
              LinearSolver* shared = nullptr);
  ~Equilibrium();
  Equilibrium(Equilibrium&&) noexcept;

  /// Which dofs are prescribed from now on. @pre none of them fixed
  void prescribe(Constraint constraint);
  const Constraint& constraint() const;
  /// Dead load: nodal forces, n_dofs; without dimension.
  void set_load(std::vector<double> load);

  struct Outcome {
    Status status = Status::converged;
    int iterations = 0;
    double relative_residual = 0;  ///< |free rows| / |reactions|
    bool met_instability = false;  ///< a tangent on the way had negative pivots
    bool left_saddle = false;      ///< the state is another than the one Newton's method came to at first
    Eigen::VectorXd force;         ///< G^T r_c, n_parameters, if converged
  };
  /// Newton from `state`, whose prescribed dofs hold their values already. On failure `state` is left as it
  /// was. Where Newton's method comes to an unstable equilibrium, it goes on downhill from there along the
  /// direction of most negative curvature. A tangent that cannot be factorized is tried once more, made
  /// convex. Converged: |free rows of r - load| <= relative_tolerance * (|reactions| + |load|), Euclidean
  /// norms, or not to be told from zero in double precision (which tiny displacements meet).
  /// @param check_stability  look whether the equilibrium is stable even if no tangent on the way had
  /// negative pivots: another factorization
  Outcome solve(std::span<double> state, bool check_stability = false);

  /// The tangent at an equilibrium state, factorized.
  struct Linearization {
    Status status = Status::converged;  ///< factorization or converged
    int negative_pivots = 0;            ///< beyond those of the pressure block
    Eigen::MatrixXd tangent;            ///< n_parameters^2: d(G^T r_c)/dq; symmetric
    Eigen::MatrixXd sensitivity;        ///< n_dofs x n_parameters: dx/dq
  };
  /// @param directions  n_parameters x k: only dx/dq times these is computed (tangent and sensitivity then
  /// have k
  ///                    columns)
  Linearization linearize(std::span<const double> state, const Eigen::MatrixXd& directions);

  /// dx/dq times `direction` at the state that solve() has just converged to, by one quasi-Newton correction
  /// of `guess` with the factors that solve() left: a predictor's velocity, a fifth of the price of
  /// linearize().
  /// @param guess  n_dofs; its prescribed dofs are overwritten
  Eigen::VectorXd velocity(std::span<const double> state, const Eigen::VectorXd& direction, Eigen::VectorXd guess);

  /// At the state that solve() has just converged to, as the latest tangent has it that was factorized on the
  /// way there; factorizes another if that one was made convex. Beyond those of the pressure block. Nothing
  /// if it has no factors.
  std::optional<int> negative_pivots(std::span<const double> state);

  /// G^T r_c: what must be applied to hold the prescribed displacement; n_parameters.
  Eigen::VectorXd force(std::span<const double> state);

  /// After an exception: begins anew with all that libraries keep between calls, whose state is then unknown.
  void recover();
  /// False after a recover() that threw: it has to be called again before anything else.
  bool is_usable() const;

  /// See ProbeSolver::set_stop(). solve() and linearize() then throw Interrupted.
  void set_stop(std::function<bool()> stop);

  SolverCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness
