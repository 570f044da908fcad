// Claims about rounding for both runtimes, each with its type of numbers.
#pragma once

#include <algorithm>

namespace phynness::test {

#ifdef PHYNNESS_FLOAT
inline constexpr bool in_float = true;
#else
inline constexpr bool in_float = false;
#endif

/// A tolerance that is a number of roundings in double, in the numbers of the runtime's inner loops: a float
/// has 29 bits less.
constexpr double rounded(double in_double) { return in_float ? in_double * 0x1p29 : in_double; }

}  // namespace phynness::test
