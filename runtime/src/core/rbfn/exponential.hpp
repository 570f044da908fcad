// exp for arguments <= 0 and powers of 1/2, for models in memory and for images. They have no branches and no calls, so
// that compilers vectorize loops and a device needs no library.
#pragma once

#include <stdint.h>

#include "core/arithmetic.hpp"

#ifdef __GNUC__
#define PHN_COPY_BITS(to, from) __builtin_memcpy(&(to), &(from), sizeof(to))
#else
#include <cstring>
#define PHN_COPY_BITS(to, from) std::memcpy(&(to), &(from), sizeof(to))
#endif

namespace PHN_RUNTIME {

/// 2^n and n for the integer n that was rounded by `shifted` = n + 1.5 2^52.
PHN_INLINE double power_of_two(double shifted) {
  uint64_t bits;
  PHN_COPY_BITS(bits, shifted);
  bits = (bits + 1023) << 52;
  double power;
  PHN_COPY_BITS(power, bits);
  return power;
}
/// Adding this constant rounds a number to an integer, which is then in the low bits of the sum.
inline constexpr double to_integer = 6755399441055744.0;

/// e^r for |r| <= ln 2 / 2 by its series; the first omitted term is 2e-16 of the value. Estrin's scheme has half the
/// dependency chain of Horner's.
PHN_INLINE double exp_series(double r) {
  const double r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
  const double low = ((1.0 / 6) * r + 0.5) * r2 + (r + 1);
  const double middle = ((1.0 / 5040) * r + 1.0 / 720) * r2 + ((1.0 / 120) * r + 1.0 / 24);
  const double high = ((1.0 / 39916800) * r + 1.0 / 3628800) * r2 + ((1.0 / 362880) * r + 1.0 / 40320);
  return (r4 * (1.0 / 479001600) + high) * r8 + (middle * r4 + low);
}

/// exp(x) for x <= 0 including -infinity; exp(-300) = 5e-131 for x < -300. That is negligible beside any constant, and
/// the product of two such values and a weight is still a normal number; subnormal numbers would be many times slower.
/// Relative error: at most 6e-16. Method: x = n ln 2 + r with |r| <= ln 2 / 2 and an integer n, which is read from the
/// low bits of a sum with 1.5 2^52; ln 2 is split into two parts (Cody & Waite 1980).
PHN_INLINE double exp_of_negative(double x) {
  constexpr double lowest = -300;
  const double clamped = x < lowest ? lowest : x;
  const double shifted = clamped * 1.4426950408889634 + to_integer;
  const double n = shifted - to_integer;
  const double r = (clamped - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
  return exp_series(r) * power_of_two(shifted);
}

/// 2^-t for t >= 0 including infinity; 2^-430 = 4e-130 for t > 430. Relative error: at most 6e-16. The remainder after
/// rounding t is exact, so that ln 2 need not be split.
PHN_INLINE double power_of_half(double t) {
  constexpr double largest = 430;
  const double clamped = t > largest ? largest : t;
  const double shifted = to_integer - clamped;
  const double r = ((to_integer - shifted) - clamped) * 0.693147180559945309417;
  return exp_series(r) * power_of_two(shifted);
}

/// The same in float; 2^-46 = 1e-14 for t > 46, so that the product of two such values and a weight is still a normal
/// number. Relative error: at most 2e-7, by float rounding. Method: -t = n + f with |f| <= 1/2; 2^f is interpolated at
/// the seven zeros of a Chebyshev polynomial with the value 1 at 0, with an error of 2e-8.
PHN_INLINE float power_of_half(float t) {
  constexpr float largest = 46, to_integer_of_float = 12582912.0f;
  const float clamped = t > largest ? largest : t;
  const float shifted = to_integer_of_float - clamped;
  uint32_t bits;
  PHN_COPY_BITS(bits, shifted);
  bits = (bits + 127) << 23;
  float power;
  PHN_COPY_BITS(power, bits);
  const float f = (to_integer_of_float - shifted) - clamped, f2 = f * f, f4 = f2 * f2;
  const float low = (0.0555032715f * f + 0.240226507f) * f2 + (0.693147182f * f + 1);
  const float high = 0.000154614449f * f2 + (0.0013400428f * f + 0.00961805694f);
  return (high * f4 + low) * power;
}

}  // namespace PHN_RUNTIME
