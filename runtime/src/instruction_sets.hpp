// Loops that take the time are compiled for several sets of instructions and chosen as the processor has them. Wider
// registers, the same operations in the same order, nothing fused: the same bits everywhere.
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

/// What stands before and after is compiled on its own as far as this array goes: GCC 12 lets the way in which a loop's
/// sums are added up at its end decide over the vectors of the loop, which then takes twice as long.
#if defined(__GNUC__) && !defined(__clang__)
#define PHN_KEEP_IN_MEMORY(array) __asm__("" : "+m"(array))
#else
#define PHN_KEEP_IN_MEMORY(array)
#endif

namespace PHN_RUNTIME {

/// 0: any processor; 1: AVX2; 2: AVX-512.
inline constexpr int n_instruction_sets = 3;

}  // namespace PHN_RUNTIME
