// The loops of family modal that take its time, compiled for several sets of instructions and chosen as the processor has
// them. Wider registers, the same operations in the same order, nothing fused: the same bits everywhere.
#pragma once

#include <cmath>

#include "prepared.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define PHN_X86_64
#endif
#ifdef __GNUC__
#define PHN_INLINE inline __attribute__((always_inline))
#else
#define PHN_INLINE inline
#endif

namespace phynness::runtime {

struct ModalKernels {
  const char* name;
  /// @param x  d / max_displacement, cut; @param scratch n_centers + 3; @param amplitude node.n_modes
  void (*amplitudes)(const phn_model& model, const ModalResponse& node, const double* x, double* scratch,
                     double* amplitude);
  /// Displacements of all output nodes, those of the probe not yet set.
  /// @param prepared   of this node, or null
  /// @param amplitude  node.n_modes > 0; @param scratch shared n_modes; @param field n_output x 3 [m]
  void (*field)(const phn_model& model, const ModalResponse& node, const PreparedNode* prepared,
                const double* amplitude, double* scratch, double* field);
  /// Shared modes times mixing, for one block of rows. @param out  node.n_modes x rows_per_block
  void (*sum_block)(const SharedModes& shared, const ModalResponse& node, const float* block, float* out);
};

/// 0: any processor; 1: AVX2; 2: AVX-512.
inline constexpr int n_instruction_sets = 3;
/// Null where library or processor lack the set.
const ModalKernels* modal_kernels(int set);
const ModalKernels& best_modal_kernels();

/// q(x - c_i) - q(x), q(x) given.
PHN_INLINE double amplitude_kernel(const SharedModes& shared, const double* x, double q, std::int32_t i) {
  const double y[3] = {x[0] - shared.center[0][i], x[1] - shared.center[1][i], x[2] - shared.center[2][i]};
  return std::sqrt(dot(y, y) + shared.shape * shared.shape) - q;
}

}  // namespace phynness::runtime
