// Arithmetic of every file of the runtime and of images: the namespace, IEEE 754 arithmetic, and a square root. No
// header of a C++ library is used, because the compiler of a device may have none.
#pragma once

// The runtime detects NaN and infinite inputs and gives bitwise the same results on every machine. With -ffast-math a
// compiler may silently remove these checks and reorder sums.
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ == 1) ||        \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__) || \
    defined(_M_FP_FAST)
#error \
    "phynness: -ffast-math, -Ofast, /fp:fast or a part of them is set, with which the runtime would not detect NaN \
inputs. Remove it for these files, or add -fno-fast-math (/fp:precise) after it. Programs that only include the headers \
may use it."
#endif

#define PHN_RUNTIME phynness::runtime

#ifdef __GNUC__
#define PHN_INLINE inline __attribute__((always_inline))
#else
#define PHN_INLINE inline
#include <math.h>
#endif

namespace PHN_RUNTIME {

#ifdef __GNUC__
inline float square_root(float value) { return __builtin_sqrtf(value); }
inline double square_root(double value) { return __builtin_sqrt(value); }
#else
inline float square_root(float value) { return ::sqrtf(value); }
inline double square_root(double value) { return ::sqrt(value); }
#endif

}  // namespace PHN_RUNTIME
