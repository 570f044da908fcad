// Factorizations of dense matrices for several fits. They are compiled in one file, because each takes the compiler ten
// seconds or more.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace phynness {

/// Orthonormal basis of the column space by Householder QR. @return rows x min(rows, cols)
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& a);

/// The x of minimal length that minimizes |a x - b|, by a complete orthogonal decomposition. @param b  rows x any
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same for one right-hand side. Its rounding differs from that for a matrix of one column. @param b  rows
Eigen::VectorXd least_squares_vector(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// a^-1 b by LDL^T. @pre a is symmetric and positive definite
Eigen::MatrixXd solve_positive_definite(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// L^-1 of a = L L^T, L lower triangular. @pre a is symmetric and positive definite
Eigen::MatrixXd inverse_cholesky_factor(const Eigen::MatrixXd& a);

/// L^-1 x and L^-T x of the lower triangle L of a, and U^-1 b of its upper triangle U.
Eigen::VectorXd solve_lower(const Eigen::Ref<const Eigen::MatrixXd>& a, Eigen::VectorXd x);
Eigen::VectorXd solve_lower_transposed(const Eigen::Ref<const Eigen::MatrixXd>& a, Eigen::VectorXd x);
Eigen::MatrixXd solve_upper(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::MatrixXd& b);

/// a^-1 by LU with partial pivoting.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& a);

/// a^-1 b by LU with full pivoting, without the pivots that are rounding.
Eigen::MatrixXd solve_full_pivoting(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same; nothing if a pivot is smaller than `threshold` times the largest one.
std::optional<Eigen::MatrixXd> solve_if_invertible(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                                   double threshold);

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< one per column, orthonormal
};
/// @pre a is symmetric
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);

struct SymmetricEigen3 {
  Eigen::Vector3d values;  ///< ascending
  Eigen::Matrix3d vectors;

  /// The symmetric matrix with the same vectors and other values.
  Eigen::Matrix3d with_values(const Eigen::Vector3d& others) const;
};
/// @pre a is symmetric
SymmetricEigen3 symmetric_eigen3(const Eigen::Matrix3d& a);

}  // namespace phynness
