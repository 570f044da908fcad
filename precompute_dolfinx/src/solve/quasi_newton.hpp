// Broyden's method for steps with the factors of an earlier tangent.
#pragma once

#include <petscvec.h>

#include <Eigen/Core>
#include <vector>

namespace phynness {

/// Steps are x <- x - length * y with y = H r. H is the inverse of the factorized tangent, corrected after each step so
/// that it maps the change of the residual to the step (Broyden 1965, doi:10.1090/S0025-5718-1965-0198670-6).
class QuasiNewton {
 public:
  /// Removes all corrections.
  void clear();
  /// Applies the corrections without adding a new one, for other right-hand sides.
  void apply(Vec y) const;
  /// @param y  on entry the substitution with the factors, on return H r
  void correct(Vec y);
  /// Records the last step for the next correction.
  void record_step(Vec y, double length);

 private:
  struct Update {
    Eigen::VectorXd u, s;  ///< H <- (1 + u s^T) H
  };
  std::vector<Update> _updates;
  Eigen::VectorXd _y;  ///< direction of the latest step
  double _length = 0;
};

}  // namespace phynness
