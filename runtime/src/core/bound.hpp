// Bounds of the force's error (formats/model.md, Bounds), for models in memory and for images.
#pragma once

#include <phynness/schema/bounds.hpp>

#include "core/lookup.hpp"
#include "core/rbfn/exponential.hpp"

namespace PHN_RUNTIME {

/// x = m 2^exponent with 0.5 <= m < 1. @param x  a normal number > 0
inline double mantissa(double x, int& exponent) {
  uint64_t bits;
  PHN_COPY_BITS(bits, x);
  exponent = static_cast<int>(bits >> 52) - 1022;
  bits = (bits & 0xfffffffffffff) | 0x3fe0000000000000;
  PHN_COPY_BITS(x, bits);
  return x;
}
inline float mantissa(float x, int& exponent) {
  uint32_t bits;
  PHN_COPY_BITS(bits, x);
  exponent = static_cast<int>(bits >> 23) - 126;
  bits = (bits & 0x7fffff) | 0x3f000000;
  PHN_COPY_BITS(x, bits);
  return x;
}

inline constexpr double log2_e = 1.4426950408889634;

/// log2 x of a normal number x > 0 to rounding, and NaN if x is not finite. The C library's function has 5 kB of
/// tables.
template <class Real>
Real logarithm_2(Real x) {
  if (!(x - x == 0)) return x - x;
  int exponent = 0;
  const Real m = mantissa(x, exponent), z = (m - Real(0.75)) / (m + Real(0.75));
  Real sum = 0;  // atanh(z) / z, |z| <= 1/5
  for (int k = sizeof(Real) == sizeof(float) ? 9 : 23; k >= 1; k -= 2) sum = sum * z * z + 1 / static_cast<Real>(k);
  return static_cast<Real>(exponent) + (Real(-0.41503749927884381) + Real(2 * log2_e) * z * sum);  // log2 0.75
}

/// exp(c_0 + sum_i c_i ln(x_i + 1e-12 N)); `most` where that is not below it.
/// @param x  three numbers >= 0 [N], which formats/model.md and formats/body.md name
template <class Real>
Real coupled_bound(const Real* c, const Real* x, Real most) {
  constexpr Real largest = sizeof(Real) == sizeof(float) ? 46 : 430;  // of power_of_half
  Real power = Real(log2_e) * c[0];
  for (int i = 0; i < schema::n_coupled_terms - 1; ++i) power += c[i + 1] * logarithm_2(x[i] + Real(1e-12));
  if (!(power < largest)) return most;
  const Real bound = power < 0 ? power_of_half(-power) : 1 / power_of_half(power);
  return bound < most ? bound : most;
}

/// The bound of one node in a direction: linear in the length of the displacement between its rows, constant beyond.
/// @param rows    n displacements of the direction, 3 each
/// @param bound   of the rows, in parts of `scale`; negative ones count as 0
/// @param square  of the displacement, in the unit of the rows
/// @param rest    gives the bound at rest
template <class Real, class Rest>
Real bound_along(const Real* rows, int32_t n, const int16_t* bound, Real scale, Real square, Rest rest) {
  int32_t j = 0;
  Real next = dot(rows, rows), before = 0;
  while (square >= next && j + 1 < n) {
    before = next;
    ++j;
    next = dot(rows + 3 * j, rows + 3 * j);
  }
  const auto value = [&](int32_t row) {
    return row < 0 ? rest() : bound[row] > 0 ? scale * static_cast<Real>(bound[row]) : Real(0);
  };
  const Real deeper = value(j);
  if (square >= next) return deeper;
  const Real shallower = value(j - 1), from = square_root(before);
  return shallower + (deeper - shallower) * ((square_root(square) - from) / (square_root(next) - from));
}

}  // namespace PHN_RUNTIME
