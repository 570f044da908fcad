// Real, the number type of the loops of forces and of family rbfn: double in phynness::runtime, float in
// phynness::runtime_float, which is built from the same files. The stiffness of family modal is summed together with
// the force. Arguments, results, energies, amplitudes, coupled tools and contact are double in both libraries; modes
// and fine surfaces are float in both.
#pragma once

#include <cfloat>
#include <cstddef>
#include <cstdint>

#include "instruction_sets.hpp"
#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

#ifdef PHYNNESS_FLOAT
using Real = float;
/// Largest weight or coefficient of a model, and the value to which inputs of networks are clamped. Sums of their
/// products with kernels are finite.
inline constexpr double largest_weight = 1e25, largest_input = 1e15;
/// Largest sum of absolute coefficients of a force; kernels of clamped inputs are below 1e7.
inline constexpr double largest_weight_sum = 1e30;
/// Largest displacement [m] that a deformation network could produce when summed in Real.
inline constexpr double largest_displacement_sum = 1e37;
#else
using Real = double;
inline constexpr double largest_weight = DBL_MAX, largest_input = DBL_MAX;
inline constexpr double largest_weight_sum = DBL_MAX, largest_displacement_sum = DBL_MAX;
#endif

/// Neurons or centers per block, independent of the width of registers, so that sums are the same on every processor.
/// Arrays are padded to whole blocks with entries that contribute nothing.
inline constexpr std::int32_t at_once = 16;
constexpr std::int32_t whole_blocks(std::int32_t n) { return (n + at_once - 1) / at_once * at_once; }

/// Adds up the lanes of three vectors of partial sums.
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

/// The same for n vectors, which it overwrites; quicker for many.
template <class T, std::size_t n>
PHN_INLINE void add_up_many(T (&sum)[n][at_once], double* total) {
  static_assert(at_once == 16);
  for (std::size_t k = 0; k < n; ++k) {
    PHN_KEEP_IN_MEMORY(sum[k]);
    for (std::int32_t i = 0; i < 8; ++i) sum[k][i] += sum[k][i + 8];
    PHN_KEEP_IN_MEMORY(sum[k]);
    for (std::int32_t i = 0; i < 4; ++i) sum[k][i] += sum[k][i + 4];
    PHN_KEEP_IN_MEMORY(sum[k]);
    total[k] = static_cast<double>((sum[k][0] + sum[k][2]) + (sum[k][1] + sum[k][3]));
  }
}

}  // namespace PHN_RUNTIME
