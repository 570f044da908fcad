// Checks of arguments and warnings, shared by the C functions.
#pragma once

#include <cmath>

#include "evaluate.hpp"
#include "overlap.hpp"

namespace PHN_RUNTIME {

inline void zero(double* values, std::int32_t n) {
  if (values == nullptr) return;
  for (std::int32_t i = 0; i < n; ++i) values[i] = 0;
}

/// Sets the outputs of a refused call to zeros. They are written last because they may overlap an input.
inline int refuse(int status, double* outputs, std::int32_t n) {
  zero(outputs, n);
  return status;
}

inline int warnings(const phn_model& model, const ActiveNode& node, const double* d) {
  return (outside(model, node, d) ? PHN_WARNING_OUTSIDE : 0) | (node.incomplete ? PHN_WARNING_INCOMPLETE : 0);
}

}  // namespace PHN_RUNTIME
