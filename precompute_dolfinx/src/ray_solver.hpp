// One ray: equilibrium followed along a straight path of prescribed displacements, with predictor and step
// cutback.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "equilibrium.hpp"
#include "path.hpp"

namespace phynness {

struct PathStep {
  Status status = Status::converged;
  int iterations = 0;  ///< Newton iterations, those of cut-back attempts included
  int cutbacks = 0;
};

class RaySolver {
 public:
  RaySolver(Discretization& body, Equilibrium& equilibrium, const SolverSpec& options)
      : _body(body), _equilibrium(equilibrium), _options(options) {}

  /// The undeformed body under the current constraint: all of its sensitivities. Shared by every ray of a
  /// probe.
  /// @throws Error if the tangent at rest is singular
  struct Rest {
    Eigen::MatrixXd sensitivity;  ///< n_dofs x n_parameters
    Eigen::MatrixXd tangent;      ///< n_parameters^2
    int negative_pivots = 0;
  };
  Rest rest();

  /// Follows q = s * direction through the ascending values `s_values`, starting at rest. Calls `take` for
  /// each value in order, until it returns false; after a failure the remaining values get
  /// Status::after_failure.
  /// @param all_tangents  compute the whole tangent at every value, not only its product with the direction
  void follow(const Rest& rest, const Eigen::VectorXd& direction, const std::vector<double>& s_values,
              bool all_tangents, const std::function<bool(std::size_t, const PathStep&, const PathPoint&)>& take);

 private:
  /// Where the path seems to go on at s; the same with the prescribed displacements in `to`.
  Prediction predict(const Path& path, const Eigen::VectorXd& direction, double s, PathPoint& to);
  /// Velocity and stability of the equilibrium in `to`.
  Status linearize(const Eigen::VectorXd& direction, const Prediction& predicted, bool all_tangents, PathPoint& to);
  /// Tries to go from the last point of `path` to parameter s; `to` is complete only if converged.
  PathStep advance(const Path& path, const Eigen::VectorXd& direction, double s, bool all_tangents, PathPoint& to);
  /// advance(), where an exception is an outcome like others: the next, shorter step may do without what
  /// failed.
  PathStep attempt(const Path& path, const Eigen::VectorXd& direction, double s, bool all_tangents, PathPoint& to);

  Discretization& _body;
  Equilibrium& _equilibrium;
  SolverSpec _options;
};

}  // namespace phynness
