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

/// basis_i = q(x - c_i) - q(x) - at_rest_i; with zeros for at_rest and x this gives at_rest.
PHN_INLINE void amplitude_basis(const SharedModes& shared, const double* x, const double* at_rest, double* basis) {
  const double s2 = shared.shape * shared.shape, q = std::sqrt(dot(x, x) + s2);
  const double *cx = shared.center[0], *cy = shared.center[1], *cz = shared.center[2];
  for (std::int32_t i = 0; i < shared.n_centers; ++i) {
    const double y[3] = {x[0] - cx[i], x[1] - cy[i], x[2] - cz[i]};
    basis[i] = (std::sqrt(dot(y, y) + s2) - q) - at_rest[i];
  }
}

}  // namespace phynness::runtime
