// Time-critical loops are compiled for several instruction sets; the one for the present processor is selected at run
// time. All variants perform the same operations in the same order without fused multiply-add, so that results are
// bitwise the same.
#pragma once

#include "precision.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define PHN_X86_64
#endif
#ifdef __GNUC__
#define PHN_INLINE inline __attribute__((always_inline))
#else
#define PHN_INLINE inline
#endif

/// Separates the optimization of the code before and after this point for the array. Otherwise GCC 12 chooses the
/// vectorization of a loop by the summation after it, and the loop takes twice as long.
#if defined(__GNUC__) && !defined(__clang__)
#define PHN_KEEP_IN_MEMORY(array) __asm__("" : "+m"(array))
#else
#define PHN_KEEP_IN_MEMORY(array)
#endif

/// Hides the value of a variable from the optimization. GCC 12 clears an array in memory even if its entries stay in
/// registers, unless it does not know that they are 0.
#if defined(__GNUC__) && !defined(__clang__)
#define PHN_HIDE(number) __asm__("" : "+m"(number))
#else
#define PHN_HIDE(number)
#endif

namespace PHN_RUNTIME {

/// 0: any processor; 1: AVX2; 2: AVX-512.
inline constexpr int n_instruction_sets = 3;

}  // namespace PHN_RUNTIME
