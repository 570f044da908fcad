// Interface of the linear solver of Newton's method, which factorizes a sequence of symmetric matrices.
#pragma once

#include <petscmat.h>
#include <petscvec.h>

#include <memory>

namespace phynness {

/// A matrix that cannot be factorized gives a return value, not an exception. Factors of a failed factorization are
/// never used.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// @param matrix  symmetric, of the same pattern since the last reset(), on this process only
  /// @return false if it could not be factorized; there are no factors then
  /// @throws Error if memory is exhausted or a library call fails; there are no factors then
  virtual bool factorize(Mat matrix) = 0;
  /// x = matrix^-1 b for the last factorized matrix.
  /// @return false if there are no factors or the solution is not finite; x is undefined then
  virtual bool solve(Vec b, Vec x) = 0;
  /// Number of negative pivots of the last matrix, including those of the pressures. @throws Error if there are no
  /// factors
  virtual int negative_pivots() = 0;
  /// Deletes the factors and all related data of the library.
  virtual void reset() = 0;
};

/// Our own LDL^T, for matrices on a single process (multifrontal.hpp).
std::unique_ptr<LinearSolver> serial_factorization();

}  // namespace phynness
