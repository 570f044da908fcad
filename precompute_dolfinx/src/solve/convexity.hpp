// Removal of negative eigenvalues from the tangents of cells and edges.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace phynness {

/// Which negative eigenvalues are removed from an element tangent: none, those larger than a thousandth of its trace
/// (which a Cholesky factorization detects), or all.
enum class Convexity { none, nearly, strictly };

/// Replaces negative eigenvalues of a matrix by zero (Teran et al. 2005, doi:10.1145/1073368.1073394).
/// @return true if there were negative eigenvalues
template <typename Matrix>
bool make_convex(Matrix& matrix, Convexity convexity) {
  // A Cholesky factorization, which takes a twentieth of the time of an eigenvalue decomposition, shows whether there
  // are negative eigenvalues. The shift accepts rigid motions, whose eigenvalues are zero up to rounding.
  Matrix shifted = matrix;
  shifted.diagonal().array() += 1e-3 * matrix.trace();
  if (convexity == Convexity::nearly && Eigen::LLT<Matrix>(shifted).info() == Eigen::Success) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix);
  if (eigen.info() != Eigen::Success || eigen.eigenvalues()[0] >= 0) return false;
  Eigen::Index n = 0;
  while (n < matrix.rows() && eigen.eigenvalues()[n] < 0) ++n;
  // The few negative eigenvalues are subtracted.
  matrix -= eigen.eigenvectors().leftCols(n) * eigen.eigenvalues().head(n).asDiagonal() *
            eigen.eigenvectors().leftCols(n).transpose();
  return true;
}

}  // namespace phynness
