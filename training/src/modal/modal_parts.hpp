// What the fits of family modal have in common: kernels, what their searches try, features of the amplitudes, and the
// selection of the centers of a force.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <phynness/training/modal_fit.hpp>

namespace phynness {

/// Shapes of the kernel that a search tries.
inline constexpr std::array shape_candidates{0.03, 0.1, 0.3, 0.6, 1.0};

/// Largest number of states in a search. With more states, which would not give better centers, complete directions are
/// omitted.
inline constexpr std::size_t max_search_states = 100;

/// q_s(y) = sqrt(|y|^2 + s^2), the kernel of amplitudes (docs/theory.md).
inline double multiquadric(const Eigen::Vector3d& y, double shape) {
  return std::sqrt(y.squaredNorm() + shape * shape);
}

/// Phi(y) = q I + y y^T / q, the Hessian of q_s^3 / 3, for forces.
inline Eigen::Matrix3d force_kernel(const Eigen::Vector3d& y, double shape) {
  const double q = multiquadric(y, shape);
  return q * Eigen::Matrix3d::Identity() + y * y.transpose() / q;
}

/// Displacements of these rows of the table, divided by the largest displacement.
Eigen::MatrixX3d scaled_rows(const TrainingTables& tables, const std::vector<std::int32_t>& rows);

/// Features of the amplitudes at each x: n x (centers + 3), for a field n x (centers + 9).
/// @param degree  degree of a field near rest; 0: a displacement
Eigen::MatrixXd features(const Eigen::MatrixX3d& x, const Eigen::MatrixX3d& centers, double shape, int degree = 0);

/// All columns of the least squares problem of a force: 3 n columns of the centers, then 6 of the stiffness, with 3 n
/// rows.
struct Columns {
  Eigen::MatrixXd centers, stiffness;
};

/// Forward selection of at most `wanted` states. Generalized cross-validation determines their number: where a body
/// snaps through, more centers would reproduce the jump at the states but be wrong between them.
/// @param rest  3 n: forces
/// @return the selected states in order
std::vector<Eigen::Index> choose_centers(Columns columns, Eigen::VectorXd rest, int wanted);

}  // namespace phynness
