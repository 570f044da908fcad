// Solution of one ray: equilibria along a straight path of prescribed displacements, with predictor and cutbacks.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "equilibrium.hpp"
#include "path.hpp"

namespace phynness {

struct PathStep {
  Status status = Status::converged;
  int iterations = 0;  ///< Newton iterations, including those of cut-back attempts
  int cutbacks = 0;
};

/// RayLimits with the dimensionless force.
struct PathLimits {
  RayLimits ray;
  double max_force = 0;  ///< of one tool; 0: no limit
};

class RaySolver {
 public:
  RaySolver(Discretization& body, Equilibrium& equilibrium, const SolverSpec& options)
      : _body(body), _equilibrium(equilibrium), _options(options) {}

  /// Sensitivities of the undeformed body under the present constraint. All rays of a probe share them.
  /// @throws Error if the tangent at rest is singular
  struct Rest {
    Eigen::MatrixXd sensitivity;  ///< n_dofs x n_parameters
    Eigen::MatrixXd tangent;      ///< n_parameters^2
    int negative_pivots = 0;
  };
  Rest rest();

  /// Follows q = s * direction through the ascending values `s_values`, starting at rest. Calls `on_state` for each
  /// value in order, until it returns false. After a failure the remaining values have Status::after_failure.
  /// @param all_tangents  whether the complete tangent is computed at every value, not only its product with the
  /// direction
  /// @return end of the ray, with dimensionless energy; its depths are values of s
  RayEnd follow(const Rest& rest, const Eigen::VectorXd& direction, const std::vector<double>& s_values,
                bool all_tangents, const std::function<bool(std::size_t, const PathStep&, const PathPoint&)>& on_state,
                const PathLimits& limits = {});

 private:
  enum class Search { smooth, fold, crushed };

  /// Advances from the last point of the path to s in steps that are halved after failures.
  /// @return Status::after_end if the ray ends before s
  PathStep advance_to(double s, bool all_tangents);
  /// Appends a converged point unless the ray ends before it. @return false if it ends
  bool accept(PathPoint to, bool all_tangents, int& iterations);
  /// Halves the step from the last point of the path to `to` until no part of it loses energy, or until the losing part
  /// is as short as the resolution. If shorter steps lead to another state, `to` becomes that state, and the path
  /// receives its previous points.
  Search search_fold(bool all_tangents, PathPoint& to, int& iterations);
  /// Whether the step loses energy, or appears to and is longer than the resolution. A shorter step is tested with the
  /// exact stiffness at its ends.
  bool loses_energy(PathPoint& from, PathPoint& to);
  void make_stiffness_exact(PathPoint& point);
  /// Sets the end of the ray if the smallest J in `to` is below the limit.
  bool is_crushed(const PathPoint& from, const PathPoint& to);
  /// Predicts the state at s. `to` receives the prediction with the prescribed displacements.
  Prediction predict(const Path& path, double s, PathPoint& to);
  /// Computes velocity and stability of the equilibrium in `to`.
  Status linearize(const Prediction& predicted, bool all_tangents, PathPoint& to);
  /// One step from the last point of `path` to s; `to` is complete if the step converged.
  PathStep advance(const Path& path, double s, bool all_tangents, PathPoint& to);
  /// Runs work with a usable solver. Logs an exception other than Interrupted and recovers the solver.
  void log_exceptions(const std::function<void()>& work);
  /// Like advance(), but returns a status for an exception, because the next, shorter step may succeed.
  PathStep try_advance(const Path& path, double s, bool all_tangents, PathPoint& to);

  Discretization& _body;
  Equilibrium& _equilibrium;
  SolverSpec _options;
  // State of the present ray.
  Eigen::VectorXd _direction;
  PathLimits _limits;
  Path _path;
  RayEnd _end;
};

}  // namespace phynness
