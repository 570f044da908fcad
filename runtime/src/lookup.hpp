// What models in memory and images in flash look up alike: a node in a list, the depth trained in a direction; and
// cutting. No header of a C++ library: images need it, too.
#pragma once

#include <stdint.h>

#include "conservative.hpp"
#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// How much longer than the trained depth a displacement may be and count as inside: the deepest increment itself is
/// inside, however its direction was rounded.
template <class Real>
inline constexpr Real depth_slack = sizeof(Real) == sizeof(float) ? static_cast<Real>(1 + 1e-6f)
                                                                  : static_cast<Real>(1 + 1e-9);

/// @pre value is a number
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
  // Halves without a branch: which one is taken cannot be foreseen.
  const int32_t* at = list;
  for (int32_t left = n; left > 1;) {
    const int32_t half = left / 2;
    at += at[half - 1] < node ? half : 0;
    left -= half;
  }
  return n > 0 && *at == node ? static_cast<int32_t>(at - list) : -1;
}

/// Depth [m] trained in the direction nearest to d; at rest the least positive one.
/// @param directions  n x 3, unit; @param depths n; @param d 3, so large or small that its products with them are
/// normal numbers, or 0
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
