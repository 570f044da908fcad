// A square root without a header of a C++ library, which the compiler of a device may not have.
#pragma once

#ifndef __GNUC__
#include <math.h>
#endif

#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

#ifdef __GNUC__
inline float square_root(float value) { return __builtin_sqrtf(value); }
inline double square_root(double value) { return __builtin_sqrt(value); }
#else
inline float square_root(float value) { return ::sqrtf(value); }
inline double square_root(double value) { return ::sqrt(value); }
#endif

}  // namespace PHN_RUNTIME
