// The direction in which an unstable equilibrium loses energy fastest.
#pragma once

#include <Eigen/Core>

#include "linear_solver.hpp"

namespace phynness {

struct NegativeCurvature {
  Eigen::VectorXd direction;  ///< n; empty if no negative curvature was found
  double curvature = 0;       ///< v K v / v P v, P the preconditioner's matrix; negative
};

/// The lowest eigenvector of K v = c P v, by the Lanczos method in the inner product of P, with all vectors
/// orthogonalized again (Parlett 1998, doi:10.1137/1.9781611971163). P and K differ in element tangents
/// that are not positive semidefinite only, so that most eigenvalues are near 1 and few steps suffice. With
/// pressures, start and all that follows lie where the pressures are in balance, in which both matrices are
/// those of the displacements with pressures condensed out.
/// @pre K has a negative eigenvalue: without one, all steps are spent before it is told so
/// @param preconditioner  has factors of P
/// @param start  n; zero where displacements are prescribed, and for pressures. It decides the sign: start .
/// v is positive; and which one of several directions with the same curvature is found
NegativeCurvature most_negative_curvature(LinearSolver& preconditioner, Mat K, const Eigen::VectorXd& start);

}  // namespace phynness
