// A Newton step with an indefinite tangent, by conjugate gradients that detect negative curvature.
#pragma once

#include "linear_solver.hpp"

namespace phynness {

struct NewtonCg {
  int iterations = 0;
  bool negative_curvature = false;
  bool failed = false;  ///< the preconditioner gave no finite result; the step is undefined
};

/// Solves K y = f with a relative accuracy of 0.1 in the preconditioner's norm, or until a direction of negative
/// curvature is found. The step along this direction has the length that it would have with the opposite curvature
/// (Steihaug 1983, doi:10.1137/0720042; length as in modified Newton methods).
/// @param preconditioner  applies the inverse of a positive definite approximation of K
/// @param y  on entry the preconditioner applied to f, on return the step; f . y > 0
NewtonCg newton_cg(LinearSolver& preconditioner, Mat K, Vec f, Vec y);

}  // namespace phynness
