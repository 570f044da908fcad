// Factorizations of dense matrices that several fits need. Each takes the compiler ten seconds or more: here it does so
// once.
#pragma once

#include <Eigen/Core>

namespace phynness {

/// Orthonormal basis of the columns' space, by Householder's QR. @return rows x min(rows, cols)
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& a);

/// x of least length among those that minimize |a x - b|, by a complete orthogonal decomposition. @param b  rows x any
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same for one right-hand side; rounds otherwise than a matrix of one column. @param b  rows
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
