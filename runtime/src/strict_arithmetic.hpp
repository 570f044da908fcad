// The runtime is compiled with the arithmetic of IEEE 754 or not at all. It tells NaN and infinite inputs from others,
// and gives the same bits everywhere; -ffast-math lets a compiler leave out the one and reorder the other, without a
// word.
#pragma once

#include "precision.hpp"

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ == 1) ||        \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__) || \
    defined(_M_FP_FAST)
#error \
    "phynness: the runtime refuses -ffast-math, -Ofast, /fp:fast and their parts: NaN inputs would no longer be \
refused. Remove them for these files, or add -fno-fast-math (/fp:precise) behind them. Programs that only include the \
headers may use them."
#endif
