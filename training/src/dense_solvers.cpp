#include "dense_solvers.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

namespace phynness {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd orthonormal(const MatrixXd& a) {
  return Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), std::min(a.rows(), a.cols()));
}

MatrixXd least_squares(const MatrixXd& a, const MatrixXd& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(a).solve(b);
}

VectorXd least_squares_vector(const MatrixXd& a, const VectorXd& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(a).solve(b);
}

MatrixXd solve_positive_definite(const MatrixXd& a, const MatrixXd& b) { return a.ldlt().solve(b); }

MatrixXd inverse_cholesky_factor(const MatrixXd& a) {
  return a.llt().matrixL().solve(MatrixXd::Identity(a.rows(), a.rows()));
}

VectorXd solve_lower(const Eigen::Ref<const MatrixXd>& a, VectorXd x) {
  a.triangularView<Eigen::Lower>().solveInPlace(x);
  return x;
}

VectorXd solve_lower_transposed(const Eigen::Ref<const MatrixXd>& a, VectorXd x) {
  a.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  return x;
}

MatrixXd solve_upper(const Eigen::Ref<const MatrixXd>& a, const MatrixXd& b) {
  return a.triangularView<Eigen::Upper>().solve(b);
}

MatrixXd inverse_of(const MatrixXd& a) { return Eigen::PartialPivLU<MatrixXd>(a).inverse(); }

MatrixXd solve_full_pivoting(const MatrixXd& a, const MatrixXd& b) { return Eigen::FullPivLU<MatrixXd>(a).solve(b); }

std::optional<MatrixXd> solve_if_invertible(const MatrixXd& a, const MatrixXd& b, double threshold) {
  Eigen::FullPivLU<MatrixXd> lu(a);
  lu.setThreshold(threshold);
  if (!lu.isInvertible()) return std::nullopt;
  return lu.solve(b);
}

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

SymmetricEigen3 symmetric_eigen3(const Eigen::Matrix3d& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(a);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Eigen::Matrix3d SymmetricEigen3::with_values(const Eigen::Vector3d& others) const {
  return vectors * others.asDiagonal() * vectors.transpose();
}

}  // namespace phynness
