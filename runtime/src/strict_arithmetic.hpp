// Refuses compilation without IEEE 754 arithmetic. The runtime detects NaN and infinite inputs and gives bitwise the
// same results on every machine. With -ffast-math a compiler may silently remove these checks and reorder sums.
#pragma once

#include "precision.hpp"

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ == 1) ||        \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__) || \
    defined(_M_FP_FAST)
#error \
    "phynness: -ffast-math, -Ofast, /fp:fast or a part of them is set, with which the runtime would not detect NaN \
inputs. Remove it for these files, or add -fno-fast-math (/fp:precise) after it. Programs that only include the headers \
may use it."
#endif
