// The time-critical loops of family modal (instruction_sets.hpp).
#pragma once

#include <cmath>

#include "instruction_sets.hpp"
#include "prepared.hpp"

namespace PHN_RUNTIME {

struct ModalKernels {
  const char* name;
  /// Basis of all amplitudes: kernels minus their values at rest, then x.
  /// @param x      d / max_displacement, clamped
  /// @param basis  n_centers + 3
  void (*basis)(const SharedModes& shared, const double* x, double* basis);
  /// Derivatives of the basis. @param gradient  3 x (n_centers + 3), row k by x_k
  void (*basis_gradient)(const SharedModes& shared, const double* x, double* gradient);
  /// amplitude = weights^T basis. @param basis  n_basis, the number of rows of tables.weight
  /// @param amplitude  tables.n_modes
  void (*amplitudes)(const ModalTables& tables, std::int32_t n_basis, const double* basis, double* amplitude);
  /// The same for three rows at once. @param basis  3 x n_basis; @param amplitude 3 x tables.n_modes
  void (*three_amplitudes)(const ModalTables& tables, std::int32_t n_basis, const double* basis, double* amplitude);
  /// Values at all output nodes; nodes that the probe moves are set later.
  /// @param prepared   of the node's deformation, or null
  /// @param amplitude  tables.n_modes > 0; @param scratch shared.n_modes; @param field shared.n_rows
  void (*field)(const SharedTable& shared, const ModalTables& tables, const PreparedNode* prepared,
                const double* amplitude, double* scratch, double* field);
  /// Product of shared modes and mixing for one block of rows. @pre tables of the full level
  /// @param out  tables.n_modes x rows_per_block
  void (*sum_block)(const SharedTable& shared, const ModalTables& tables, const float* block, float* out);
};

/// Null if the library or the processor does not have the instruction set.
const ModalKernels* modal_kernels(int set);
const ModalKernels& best_modal_kernels();

/// q(x - c_i) - q(x) for a given q = q(x).
PHN_INLINE double amplitude_kernel(const SharedModes& shared, const double* x, double q, std::int32_t i) {
  const double y[3] = {x[0] - shared.center[0][i], x[1] - shared.center[1][i], x[2] - shared.center[2][i]};
  return std::sqrt(dot(y, y) + shared.shape * shared.shape) - q;
}

}  // namespace PHN_RUNTIME
