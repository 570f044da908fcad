// The direction of most negative curvature at an unstable equilibrium.
#pragma once

#include <Eigen/Core>

#include "linear_solver.hpp"

namespace phynness {

struct NegativeCurvature {
  Eigen::VectorXd direction;  ///< n; empty if no negative curvature was found
  double curvature = 0;       ///< v K v / v P v with the preconditioner's matrix P; negative
};

/// The eigenvector of K v = c P v with the smallest eigenvalue, by the Lanczos method in the inner product of P with
/// full reorthogonalization (Parlett 1998, doi:10.1137/1.9781611971163). P and K differ only in element tangents that
/// are not positive semidefinite, so that most eigenvalues are near 1 and a few steps suffice. With pressures, all
/// vectors are in the subspace in which the pressure equations hold; there both matrices are those of the displacements
/// with condensed pressures.
/// @pre K has a negative eigenvalue; otherwise all steps are executed before the result is empty
/// @param preconditioner  has factors of P
/// @param start  n; zero for prescribed displacements and for pressures. It determines the sign of the result, start .
///               v > 0, and which of several directions with the same curvature is found
NegativeCurvature most_negative_curvature(LinearSolver& preconditioner, Mat K, const Eigen::VectorXd& start);

}  // namespace phynness
