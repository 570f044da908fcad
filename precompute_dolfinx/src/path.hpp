// Where a ray has been, and where it is likely to go: Hermite extrapolation.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

namespace phynness {

/// A converged state on the path, without dimension.
struct PathPoint {
  double s = 0;               ///< path parameter: q = s * direction
  std::vector<double> state;  ///< n_dofs
  Eigen::VectorXd velocity;   ///< dx/ds, n_dofs
  Eigen::VectorXd force;      ///< n_parameters
  Eigen::MatrixXd tangent;    ///< n_parameters^2 if all of it was asked for, else empty
  double energy = 0, min_jacobian = 1;
  int negative_pivots = 0;
  bool met_instability = false;  ///< here or before
  bool jumped = false;           ///< no neighbour of the points before it: the body buckled
};

/// The polynomial through states and velocities of a few points, continued to s.
struct Prediction {
  Eigen::VectorXd state, velocity;  ///< n_dofs
  /// The error grows with the product of (s - s_i) over the points, twice each; this is its logarithmic
  /// derivative: velocity + growth * (converged state - state) is the better guess afterwards.
  double growth = 0;
};

class Path {
 public:
  void clear() { _points.clear(); }
  void append(PathPoint point);
  const PathPoint& last() const { return _points.back(); }
  /// Points that a prediction to s may use: the latest ones, as far back as the step to s is long.
  int n_points(double s) const;
  /// By the latest k points: degree 2 k - 1, divided differences with every point twice.
  Prediction predict(int k, double s) const;

 private:
  std::deque<PathPoint> _points;
};

}  // namespace phynness
