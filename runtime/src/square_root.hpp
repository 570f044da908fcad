// A square root that needs no header of a C++ library: those of a device's compiler may be absent.
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
