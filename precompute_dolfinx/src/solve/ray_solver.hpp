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

/// RayLimits of dimensionless paths.
struct PathLimits {
  RayLimits ray;
  double max_force = 0;  ///< of one tool; 0: no limit
};

class RaySolver {
 public:
  RaySolver(Discretization& body, Equilibrium& equilibrium, const SolverSpec& options)
      : _body(body), _equilibrium(equilibrium), _options(options) {}

  /// Sensitivities of the undeformed body under the present constraint, used by all rays of a probe.
  /// @throws Error if the tangent at rest is singular
  struct Rest {
    Eigen::MatrixXd sensitivity;  ///< n_dofs x n_parameters
    Eigen::MatrixXd tangent;      ///< n_parameters^2
    int negative_pivots = 0;
  };
  Rest rest();

  /// Follows q = s * direction through the ascending values `s_values`, starting at rest. Calls `take` for each value
  /// in order, until it returns false. After a failure the remaining values have Status::after_failure.
  /// @param all_tangents  compute the complete tangent at every value, not only its product with the direction
  /// @return end of the ray, with dimensionless energy; its depths are values of s
  RayEnd follow(const Rest& rest, const Eigen::VectorXd& direction, const std::vector<double>& s_values,
                bool all_tangents, const std::function<bool(std::size_t, const PathStep&, const PathPoint&)>& take,
                const PathLimits& limits = {});

 private:
  enum class Search { smooth, fold, crushed };

  /// Goes from the last point of the path to s in steps that are halved after failures.
  /// @return Status::after_end if the ray ends before s
  PathStep advance_to(double s, bool all_tangents);
  /// Appends a converged point unless the ray ends before it. @return false if it ends
  bool accept(PathPoint to, bool all_tangents, int& iterations);
  /// Halves the step from the last point of the path to `to` until no part of it loses energy, or the part that does is
  /// as short as the resolution. If shorter steps lead to another state, `to` becomes that state and the path receives
  /// the points before it.
  Search search_fold(bool all_tangents, PathPoint& to, int& iterations);
  /// True if the step loses energy, or if it may do so and is longer than the resolution. The stiffness at the ends of
  /// a shorter step is computed exactly before the answer.
  bool loses_energy(PathPoint& from, PathPoint& to);
  void make_stiffness_exact(PathPoint& point);
  /// Sets the end of the ray if the smallest J in `to` is below the limit.
  bool is_crushed(const PathPoint& from, const PathPoint& to);
  /// Predicts the state at s. `to` receives the prediction with the prescribed displacements.
  Prediction predict(const Path& path, double s, PathPoint& to);
  /// Computes velocity and stability of the equilibrium in `to`.
  Status linearize(const Prediction& predicted, bool all_tangents, PathPoint& to);
  /// One step from the last point of `path` to parameter s; `to` is only complete if the step converged.
  PathStep advance(const Path& path, double s, bool all_tangents, PathPoint& to);
  /// Runs work with a usable solver. An exception other than Interrupted goes to the log, and the solver recovers.
  void contain(const std::function<void()>& work);
  /// As advance(), but an exception gives a status, because the next, shorter step may succeed.
  PathStep attempt(const Path& path, double s, bool all_tangents, PathPoint& to);

  Discretization& _body;
  Equilibrium& _equilibrium;
  SolverSpec _options;
  // Of the present ray.
  Eigen::VectorXd _direction;
  PathLimits _limits;
  Path _path;
  RayEnd _end;
};

}  // namespace phynness
