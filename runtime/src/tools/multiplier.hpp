// The forces that hold the points in the undeformed body: multipliers of their constraints.
#pragma once

#include "tools/coupled_field.hpp"

namespace PHN_RUNTIME {

class Multipliers : protected CoupledField {
 protected:
  using CoupledField::CoupledField;

  /// Computes, from the derivatives of the points by the p in the undeformed body, the forces that move the points by
  /// given displacements, and for each tool the part of its displacement that remains when the others hold their
  /// points. Compliances are scaled to 1 for each tool alone. An almost singular compliance means that tools are too
  /// close together to be distinguished; there the inverse goes to 0 with the eigenvalue instead of to infinity.
  void find_stiffness();
  /// Forces of the undeformed body at all points for given displacements of the points.
  void multiply(const Vector* moved, Vector* multiplier) const;
  /// Replaces `right` by the change of the p that produces it in the undeformed body, as far as the tools can be
  /// distinguished.
  bool correct();

 private:
  /// Block (t, s) of the inverse of the scaled compliances. @pre they are diagonalized
  Matrix inverse_block(std::int32_t t, std::int32_t s) const;

  bool _apart = true;  ///< all tools can be distinguished
};

}  // namespace PHN_RUNTIME
