// A Newton step where the tangent is indefinite: conjugate gradients that notice negative curvature.
#pragma once

#include "linear_solver.hpp"

namespace phynness {

struct NewtonCg {
  int iterations = 0;
  bool negative_curvature = false;
  bool failed = false;  ///< the preconditioner had no finite answer; the step is undefined
};

/// Solves K y = f to a tenth in the preconditioner's norm, or until a direction of negative curvature is met,
/// along which the step then goes as far as if the curvature were positive (Steihaug 1983,
/// doi:10.1137/0720042; the length as in modified Newton methods).
/// @param preconditioner  applies the inverse of a positive definite neighbour of K
/// @param y  on entry the preconditioner's answer to f, on return the step; f . y > 0
NewtonCg newton_cg(LinearSolver& preconditioner, Mat K, Vec f, Vec y);

}  // namespace phynness
