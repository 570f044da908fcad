#include "newton_cg.hpp"

#include <cmath>

#include "petsc_check.hpp"

namespace phynness {
NewtonCg newton_cg(LinearSolver& preconditioner, Mat K, Vec f, Vec y) {
  constexpr int most_iterations = 40;
  constexpr double reduction = 0.1;
  PetscVec r, z, p, q;
  for (auto* vector : {&r, &z, &p, &q}) PHYNNESS_PETSC(VecDuplicate(f, vector->address()));
  PHYNNESS_PETSC(VecCopy(f, r));
  PHYNNESS_PETSC(VecCopy(y, z));
  PHYNNESS_PETSC(VecCopy(y, p));
  PHYNNESS_PETSC(VecSet(y, 0));

  NewtonCg out;
  double rz = dot(r, z);
  double p_squared = rz;  // p M p with the preconditioner's matrix M
  const double goal = reduction * reduction * rz;
  while (out.iterations < most_iterations) {
    ++out.iterations;
    PHYNNESS_PETSC(MatMult(K, p, q));
    const double curvature = dot(p, q);
    out.negative_curvature = !(curvature > 0);
    PHYNNESS_PETSC(VecAXPY(y, rz / (out.negative_curvature ? p_squared : curvature), p));
    if (out.negative_curvature) break;
    PHYNNESS_PETSC(VecAXPY(r, -rz / curvature, q));
    if (!preconditioner.solve(r, z)) {
      out.failed = true;
      break;
    }
    const double next = dot(r, z);
    if (!(next > goal)) break;
    PHYNNESS_PETSC(VecAYPX(p, next / rz, z));
    p_squared = next + (next / rz) * (next / rz) * p_squared;
    rz = next;
  }
  return out;
}

}  // namespace phynness
