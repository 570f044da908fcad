// Functions for models in memory and for images: products, clamping, the nearest point of a triangle, search of a node
// in a list, trained depth in a direction, overlap of memory. No header of a C++ library is used, because images are
// evaluated without one.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/arithmetic.hpp"

namespace PHN_RUNTIME {

template <class Real>
Real dot(const Real* a, const Real* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// K d, with K given as xx xy xz yy yz zz.
template <class Real>
void multiply_symmetric(const Real* k, const Real* d, Real* product) {
  product[0] = k[0] * d[0] + k[1] * d[1] + k[2] * d[2];
  product[1] = k[1] * d[0] + k[3] * d[1] + k[4] * d[2];
  product[2] = k[2] * d[0] + k[4] * d[1] + k[5] * d[2];
}

/// K as 3 x 3.
template <class Real>
void fill_symmetric(const Real* k, Real* matrix) {
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) matrix[3 * i + j] = matrix[3 * j + i] = *k++;
}

/// A displacement counts as inside of the trained range up to this factor of the depth, so that the deepest increment
/// is inside in spite of the rounding of its direction.
template <class Real>
inline constexpr Real depth_slack = sizeof(Real) == sizeof(float) ? static_cast<Real>(1 + 1e-6f)
                                                                  : static_cast<Real>(1 + 1e-9);

/// Smallest sum of the weights of moving corners in a place. The stiffness of a point grows without bound towards a
/// fixed edge.
template <class Real>
inline constexpr Real smallest_movable_weight = static_cast<Real>(0.05);
/// Raises the weights of moving corners to this sum if their sum `movable` is below it. @return whether it was below
template <class Real>
bool raise_movable_weight(const bool* moves, int n, Real movable, Real* weight) {
  if (movable >= smallest_movable_weight<Real>) return false;
  int n_moving = 0;
  for (int c = 0; c < n; ++c) n_moving += moves[c];
  for (int c = 0; c < n; ++c) {
    if (!moves[c]) {
      weight[c] *= (1 - smallest_movable_weight<Real>) / (1 - movable);
    } else {
      weight[c] = movable > 0 ? weight[c] * smallest_movable_weight<Real> / movable
                              : smallest_movable_weight<Real> / static_cast<Real>(n_moving);
    }
  }
  return true;
}

/// Corners with a smaller share of a place give no warning and no bound. Such shares are rounding errors of places in
/// single precision.
inline constexpr double least_share = 1e-5;

/// @pre value is not NaN
template <class Real>
Real clamp(Real value, Real largest) {
  return value > largest ? largest : value < -largest ? -largest : value;
}

template <class Real>
bool finite(const Real* d) {
  return d[0] - d[0] == 0 && d[1] - d[1] == 0 && d[2] - d[2] == 0;
}

/// The point of a triangle nearest to x, by the regions of Ericson, Real-Time Collision Detection (2005), 5.1.5.
/// @param w  barycentric weights, >= 0, sum 1
template <class Real>
void nearest_weights(const Real* const corner[3], const Real* x, Real* w) {
  const Real *a = corner[0], *b = corner[1], *c = corner[2];
  Real ab[3], ac[3], ax[3], bx[3], cx[3];
  for (int k = 0; k < 3; ++k) {
    ab[k] = b[k] - a[k];
    ac[k] = c[k] - a[k];
    ax[k] = x[k] - a[k];
    bx[k] = x[k] - b[k];
    cx[k] = x[k] - c[k];
    w[k] = 0;
  }
  const Real d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx), d5 = dot(ab, cx), d6 = dot(ac, cx);
  const Real va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  const auto share = [](Real part, Real rest) { return part + rest > 0 ? part / (part + rest) : 0; };
  const auto between = [](Real value, Real most) { return value > 0 ? value < most ? value : most : 0; };
  if (d1 <= 0 && d2 <= 0) {
    w[0] = 1;
  } else if (d3 >= 0 && d4 <= d3) {
    w[1] = 1;
  } else if (d6 >= 0 && d5 <= d6) {
    w[2] = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    w[1] = share(d1, -d3);
    w[0] = 1 - w[1];
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    w[2] = share(d2, -d6);
    w[0] = 1 - w[2];
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    w[2] = share(d4 - d3, d5 - d6);
    w[1] = 1 - w[2];
  } else {
    const Real sum = va + vb + vc;
    w[1] = sum != 0 ? between(vb / sum, 1) : 0;
    w[2] = sum != 0 ? between(vc / sum, 1 - w[1]) : 0;
    w[0] = 1 - w[1] - w[2];
  }
}

/// Angle between two vectors [rad] to 1e-4 (Abramowitz & Stegun 1964, 4.4.45), without a library. @pre they are not 0
template <class Real>
[[gnu::cold]] Real approximate_angle(const Real* a, const Real* b) {
  const Real cosine = clamp(dot(a, b) / (square_root(dot(a, a)) * square_root(dot(b, b))), Real(1));
  const Real x = cosine < 0 ? -cosine : cosine;
  const Real angle =
      square_root(1 - x) * (Real(1.5707288) + x * (Real(-0.2121144) + x * (Real(0.0742610) + x * Real(-0.0187293))));
  return cosine < 0 ? Real(3.14159265358979) - angle : angle;
}

/// The component of `away` along the outward normal of a place: that of its triangle, the sum of both at an edge, and
/// at a vertex the sum times the angles, with which the sign is right at sharp corners, too (Baerentzen & Aanaes 2005,
/// doi 10.1109/TVCG.2005.49). 0 at the border of the surface.
/// @param vertex_of  number of corner k of triangle t
/// @param vertex, weight  of the place; only those with a weight count
template <class Real, class Vertex, class VertexOf, class PointOf>
[[gnu::cold]] Real height_above(uint32_t n_triangles, const VertexOf& vertex_of, const PointOf& point_of,
                                const Vertex* vertex, const Real* weight, const Real* away) {
  Real height = 0;
  uint32_t open = 0;  // 0 if the vertices around the place are as often the next one as the last one
  for (uint32_t t = 0; t < n_triangles; ++t) {
    int n = 0, n_found = 0, at = 0;
    for (int c = 0; c < 3 && n == n_found; ++c) {
      if (!(weight[c] > 0)) continue;
      ++n;
      for (int k = 0; k < 3; ++k) {
        if (vertex_of(t, k) != vertex[c]) continue;
        at = k;
        ++n_found;
      }
    }
    if (n_found < n) continue;
    const auto next = vertex_of(t, (at + 1) % 3), last = vertex_of(t, (at + 2) % 3);
    const Real *corner = point_of(vertex_of(t, at)), *p = point_of(next), *q = point_of(last);
    const Real a[3] = {p[0] - corner[0], p[1] - corner[1], p[2] - corner[2]};
    const Real b[3] = {q[0] - corner[0], q[1] - corner[1], q[2] - corner[2]};
    const Real normal[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const Real area = square_root(dot(normal, normal));
    if (area > 0) height += dot(normal, away) / area * (n == 1 ? approximate_angle(a, b) : 1);
    if (n == 1) open += static_cast<uint32_t>(next) - static_cast<uint32_t>(last);
    if (n == 2) open ^= 1;
  }
  return open == 0 ? height : 0;
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

/// Whether memory of the caller overlaps. Null and empty ranges do not overlap anything.
inline bool overlap(const void* a, size_t a_bytes, const void* b, size_t b_bytes) {
  if (a == nullptr || b == nullptr || a_bytes == 0 || b_bytes == 0) return false;
  const auto at_a = reinterpret_cast<uintptr_t>(a), at_b = reinterpret_cast<uintptr_t>(b);
  return at_a < at_b ? at_b - at_a < a_bytes : at_a - at_b < b_bytes;
}

/// Slope at which the trained range widens away from a shorter neighbor (formats/model.md, Range).
template <class Real>
inline constexpr Real widening = 2;

/// Depth [m] of the trained range in the direction of d; at rest the smallest positive depth. In the middle between two
/// exploratory directions it is the smaller of their depths, from there on it widens to that of the nearest direction.
/// @param directions  n x 3 unit vectors
/// @param depths      n
/// @param d           3; its products with the directions must be normal numbers or 0
/// @param size        |d|
/// @param largest     max_displacement
template <class Real>
Real depth_along(const Real* directions, const Real* depths, int32_t n, const Real* d, Real size, Real largest) {
  const bool moves = d[0] != 0 || d[1] != 0 || d[2] != 0;
  Real depth = 0, best = 0;
  const Real* e = directions;
  for (int32_t i = 0; i < n; ++i, e += 3) {
    if (moves) {
      const Real along = dot(d, e);
      if (i == 0 || along > best) {
        best = along;
        depth = depths[i];
      }
    } else if (depths[i] > 0 && (depth == 0 || depths[i] < depth)) {
      depth = depths[i];
    }
  }
  if (!moves) return depth;
  const Real longest = size > best ? size : best;
  e = directions;
  for (int32_t i = 0; i < n; ++i, e += 3) {
    if (!(depths[i] < depth)) continue;
    const Real along = dot(d, e);
    const Real reach = depths[i] + widening<Real> * largest * ((best - along) / (longest - along));
    // Both are 0 where the directions are parallel. The comparison then is with NaN, and the depth is the smaller one.
    if (!(reach >= depth)) depth = depths[i] < reach ? reach : depths[i];
  }
  return depth;
}

}  // namespace PHN_RUNTIME
