// The number that the loops of forces and of family rbfn compute in: phynness::runtime is built with double,
// phynness::runtime_float, from the same files, with float. Arguments, results, energies, stiffnesses, amplitudes,
// coupled tools and contact are double in both; modes and fine surfaces are float in both.
#pragma once

#include <cfloat>
#include <cstdint>

#include "instruction_sets.hpp"
#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

#ifdef PHYNNESS_FLOAT
using Real = float;
/// Weights and coefficients that models may hold, and inputs of networks, which are cut there: sums of them times
/// kernels stay finite.
inline constexpr double largest_weight = 1e25, largest_input = 1e15;
/// Sums of sizes of coefficients of a force: kernels of inputs that are cut stay below 1e7.
inline constexpr double largest_weight_sum = 1e30;
/// Displacements [m] that a deformation network could reach, summed in Real.
inline constexpr double largest_displacement_sum = 1e37;
#else
using Real = double;
inline constexpr double largest_weight = DBL_MAX, largest_input = DBL_MAX;
inline constexpr double largest_weight_sum = DBL_MAX, largest_displacement_sum = DBL_MAX;
#endif

/// Neurons or centers at a time, whatever the width of registers: sums are the same everywhere. Arrays of them are
/// filled up to whole multiples with what counts nothing.
inline constexpr std::int32_t at_once = 16;
constexpr std::int32_t whole_blocks(std::int32_t n) { return (n + at_once - 1) / at_once * at_once; }

/// Sums of the lanes of three sums.
PHN_INLINE void add_up(const Real (&sums)[3][at_once], double* total) {
  Real sum[3][at_once];
  for (int k = 0; k < 3; ++k) {
    for (std::int32_t i = 0; i < at_once; ++i) sum[k][i] = sums[k][i];
  }
  PHN_KEEP_IN_MEMORY(sum);
  for (int k = 0; k < 3; ++k) {
    for (std::int32_t half = at_once / 2; half > 0; half /= 2) {
      for (std::int32_t i = 0; i < half; ++i) sum[k][i] += sum[k][i + half];
    }
    total[k] = static_cast<double>(sum[k][0]);
  }
}

}  // namespace PHN_RUNTIME
