// Functions for models in memory and for images: search of a node in a list, trained depth in a direction, clamping. No
// header of a C++ library is used, because images are evaluated without one.
#pragma once

#include <stdint.h>

#include "conservative.hpp"
#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// A displacement may exceed the trained depth by this factor and still count as inside, so that the deepest increment
/// itself is inside despite the rounding of its direction.
template <class Real>
inline constexpr Real depth_slack = sizeof(Real) == sizeof(float) ? static_cast<Real>(1 + 1e-6f)
                                                                  : static_cast<Real>(1 + 1e-9);

/// @pre value is not NaN
template <class Real>
Real cut(Real value, Real largest) {
  return value > largest ? largest : value < -largest ? -largest : value;
}

template <class Real>
bool finite(const Real* d) {
  return d[0] - d[0] == 0 && d[1] - d[1] == 0 && d[2] - d[2] == 0;
}

/// Position of `node` in an ascending list of n, or -1.
inline int32_t find_sorted(const int32_t* list, int32_t n, int32_t node) {
  // Binary search without branches, because the processor could not predict them.
  const int32_t* at = list;
  for (int32_t left = n; left > 1;) {
    const int32_t half = left / 2;
    at += at[half - 1] < node ? half : 0;
    left -= half;
  }
  return n > 0 && *at == node ? static_cast<int32_t>(at - list) : -1;
}

/// Trained depth [m] in the direction nearest to d; at rest the smallest positive depth.
/// @param directions  n x 3 unit vectors
/// @param depths      n
/// @param d           3; its products with the directions must be normal numbers or 0
template <class Real>
Real depth_along(const Real* directions, const Real* depths, int32_t n, const Real* d) {
  const bool moves = d[0] != 0 || d[1] != 0 || d[2] != 0;
  Real depth = 0, best = 0;
  for (int32_t i = 0; i < n; ++i, directions += 3) {
    if (moves) {
      const Real along = dot(d, directions);
      if (i == 0 || along > best) {
        best = along;
        depth = depths[i];
      }
    } else if (depths[i] > 0 && (depth == 0 || depths[i] < depth)) {
      depth = depths[i];
    }
  }
  return depth;
}

}  // namespace PHN_RUNTIME
