// The converged states of a ray, and their Hermite extrapolation.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

namespace phynness {

/// A converged state on the path, dimensionless.
struct PathPoint {
  double s = 0;               ///< path parameter: q = s * direction
  std::vector<double> state;  ///< n_dofs
  Eigen::VectorXd velocity;   ///< dx/ds, n_dofs
  Eigen::VectorXd force;      ///< n_parameters
  Eigen::MatrixXd tangent;    ///< n_parameters^2; empty unless all tangents are computed
  double energy = 0, min_jacobian = 1;
  double stiffness = 0;         ///< d^2 energy / ds^2: the change of force * direction along the path
  bool exact_stiffness = true;  ///< false: it is estimated from the velocity
  int negative_pivots = 0;
  bool met_instability = false;  ///< at this or an earlier point
  bool has_buckled = false;      ///< so that the state is far from the previous points
};

/// The extrapolation to s of the polynomial through states and velocities of a few points.
struct Prediction {
  Eigen::VectorXd state, velocity;  ///< n_dofs
  /// The error is proportional to the product of (s - s_i)^2 over the points. This is the logarithmic derivative of
  /// this product, so that velocity + growth * (converged state - state) is an improved velocity after convergence.
  double growth = 0;
};

class Path {
 public:
  void append(PathPoint point);
  const PathPoint& last() const { return _points.back(); }
  PathPoint& last() { return _points.back(); }
  /// Number of latest points that a prediction to s may use; it is limited by the length of the step to s.
  int n_points(double s) const;
  /// Hermite extrapolation from the latest k points, of degree 2 k - 1, by divided differences with double points.
  Prediction predict(int k, double s) const;

 private:
  std::deque<PathPoint> _points;
};

}  // namespace phynness
