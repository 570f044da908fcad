// Overlap of memory of the caller. No header of a C++ library is used, because images are evaluated without one.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// Null and empty ranges do not overlap anything.
inline bool overlap(const void* a, size_t a_bytes, const void* b, size_t b_bytes) {
  if (a == nullptr || b == nullptr || a_bytes == 0 || b_bytes == 0) return false;
  const auto at_a = reinterpret_cast<uintptr_t>(a), at_b = reinterpret_cast<uintptr_t>(b);
  return at_a < at_b ? at_b - at_a < a_bytes : at_a - at_b < b_bytes;
}

}  // namespace PHN_RUNTIME
