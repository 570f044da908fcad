// LDL^T by MUMPS, for a team of ranks.
#pragma once

#include "linear_solver.hpp"
#include "petsc_check.hpp"

namespace phynness {

/// All functions are collective over the communicator of the matrix.
class Factorization : public LinearSolver {
 public:
  bool factorize(Mat matrix) override;
  bool solve(Vec b, Vec x) override;
  int negative_pivots() override;
  void reset() override;

 private:
  void analyse(Mat matrix);
  bool refactorize(Mat matrix);

  PetscMat _factors;
  bool _good = false;
};

}  // namespace phynness
