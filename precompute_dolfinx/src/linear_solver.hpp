// What Newton's method solves its linear systems with: factors of one symmetric matrix after the other.
#pragma once

#include <petscmat.h>
#include <petscvec.h>

namespace phynness {

/// A matrix that cannot be factorized is an answer, not an exception. Factors of a factorization that failed
/// are never used.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// @param matrix  symmetric, of the same pattern every time, on this process alone
  /// @return false if it could not be factorized; there are no factors then
  /// @throws Error if memory runs out or a library call fails; no factors either
  virtual bool factorize(Mat matrix) = 0;
  /// x = matrix^-1 b, of the latest that was factorized.
  /// @return false, and x is undefined, if there are no factors or the answer is not finite
  virtual bool solve(Vec b, Vec x) = 0;
  /// Of the latest matrix, those of the pressures included. @throws Error if there are no factors
  virtual int negative_pivots() = 0;
  /// Drops the factors, and what the library keeps of them.
  virtual void reset() = 0;
};

}  // namespace phynness
