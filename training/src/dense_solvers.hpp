// Factorizations of dense matrices for several fits. They are compiled in one file, because each takes the compiler ten
// seconds or more.
#pragma once

#include <Eigen/Core>

namespace phynness {

/// Orthonormal basis of the column space by Householder QR. @return rows x min(rows, cols)
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& a);

/// The x of minimal length that minimizes |a x - b|, by a complete orthogonal decomposition. @param b  rows x any
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same for one right-hand side. Its rounding differs from that for a matrix of one column. @param b  rows
Eigen::VectorXd least_squares_vector(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// a^-1 b by LDL^T. @pre a is symmetric and positive definite
Eigen::MatrixXd solve_positive_definite(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< one per column, orthonormal
};
/// @pre a is symmetric
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);

}  // namespace phynness
