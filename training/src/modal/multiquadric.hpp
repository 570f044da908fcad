// The kernels of family modal: q_s(y) = sqrt(|y|^2 + s^2) for amplitudes, and the Hessian of q_s^3 / 3 for forces
// (docs/theory.md).
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace phynness {

inline double multiquadric(const Eigen::Vector3d& y, double shape) {
  return std::sqrt(y.squaredNorm() + shape * shape);
}

/// q(x - c) - q(x) - q(c) + q(0)
inline double anchored_multiquadric(const Eigen::Vector3d& x, const Eigen::Vector3d& c, double shape) {
  return multiquadric(x - c, shape) - multiquadric(x, shape) - multiquadric(c, shape) + shape;
}

/// Phi(y) = q I + y y^T / q
inline Eigen::Matrix3d force_kernel(const Eigen::Vector3d& y, double shape) {
  const double q = multiquadric(y, shape);
  return q * Eigen::Matrix3d::Identity() + y * y.transpose() / q;
}

}  // namespace phynness
