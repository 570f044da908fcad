// The linear solver of Newton's method, which factorizes a sequence of symmetric matrices: LDL^T (multifrontal.hpp).
#pragma once

#include <petscmat.h>
#include <petscvec.h>

#include <optional>

#include "multifrontal.hpp"

namespace phynness {

/// A matrix that cannot be factorized gives a return value, not an exception. Factors of a failed factorization are
/// never used.
class Factorization {
 public:
  /// @param matrix  symmetric, of the same pattern since the last reset(), on this process only
  /// @return false if it could not be factorized; there are no factors then
  /// @throws Error if memory is exhausted or a library call fails; there are no factors then
  bool factorize(Mat matrix);
  /// x = matrix^-1 b for the last factorized matrix.
  /// @return false if there are no factors or the solution is not finite; x is undefined then
  bool solve(Vec b, Vec x);
  /// Number of negative pivots of the last matrix, including those of the pressures. @throws Error if there are no
  /// factors
  int negative_pivots();
  /// Deletes the factors.
  void reset();

 private:
  std::optional<Multifrontal> _factors;
  bool _has_factors = false;
};

}  // namespace phynness
