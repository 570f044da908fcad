#include "factorization.hpp"

#include <cmath>
#include <string>

namespace phynness {

void Factorization::analyse(Mat matrix) {
  // Options of MUMPS in PETSC_OPTIONS have this prefix.
  PHYNNESS_PETSC(MatSetOptionsPrefixFactor(matrix, "phynness_"));
  // LDL^T gives the number of negative pivots.
  PHYNNESS_PETSC(MatGetFactor(matrix, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, _factors.address()));
  // The matrix is definite or, with pressures, quasi-definite (Vanderbei 1995, doi:10.1137/0805005). It needs neither
  // scaling nor pivoting, which would take a tenth to a fifth of the time.
  PHYNNESS_PETSC(MatMumpsSetIcntl(_factors, 8, 0));
  PHYNNESS_PETSC(MatMumpsSetCntl(_factors, 1, 0.0));
  // In parallel the last front would be factorized by ScaLAPACK, which does not count negative pivots.
  PHYNNESS_PETSC(MatMumpsSetIcntl(_factors, 13, 1));
  MatFactorInfo info;
  PHYNNESS_PETSC(MatFactorInfoInitialize(&info));
  PHYNNESS_PETSC(MatCholeskyFactorSymbolic(_factors, matrix, nullptr, &info));
}

bool Factorization::refactorize(Mat matrix) {
  if (!_factors) analyse(matrix);
  MatFactorInfo info;
  MatFactorError error = MAT_FACTOR_NOERROR;
  PHYNNESS_PETSC(MatFactorInfoInitialize(&info));
  PHYNNESS_PETSC(MatCholeskyFactorNumeric(_factors, matrix, &info));
  PHYNNESS_PETSC(MatFactorGetError(_factors, &error));
  if (error == MAT_FACTOR_NOERROR) return true;
  PetscInt reason = 0;
  PHYNNESS_PETSC(MatMumpsGetInfog(_factors, 1, &reason));
  constexpr PetscInt numerically_singular = -10;
  if (reason == numerically_singular) return false;
  throw failure("MUMPS could not factorize a tangent", "INFOG(1) = " + std::to_string(reason),
                "usually the memory is too small (-8, -9, -13, -19): give each rank more memory, or use fewer ranks on "
                "each machine");
}

bool Factorization::factorize(Mat matrix) {
  _good = false;
  try {
    _good = refactorize(matrix);
  } catch (...) {
    reset();
    throw;
  }
  // MUMPS keeps the error of a failed factorization. PETSc would then skip the next factorization, treat it as
  // successful and abort in the solve. Only a new analysis clears the error.
  if (!_good) reset();
  return _good;
}

bool Factorization::solve(Vec b, Vec x) {
  if (!_good) return false;
  try {
    PHYNNESS_PETSC(MatSolve(_factors, b, x));
  } catch (...) {
    reset();
    throw;
  }
  PetscReal norm = 0;
  PHYNNESS_PETSC(VecNorm(x, NORM_1, &norm));
  return std::isfinite(norm);
}

int Factorization::negative_pivots() {
  if (!_good) throw failure("pivots cannot be counted without factors", "", "please report this defect");
  PetscInt negative = 0;
  PHYNNESS_PETSC(MatGetInertia(_factors, &negative, nullptr, nullptr));
  return static_cast<int>(negative);
}

void Factorization::reset() {
  _factors = {};
  _good = false;
}

}  // namespace phynness
