#include "core/evaluate.hpp"
#include "core/kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// The first n entries of row r of a table times a vector.
PHN_INLINE double row_times(const std::int16_t* table, std::int32_t n_columns, const double* scale, std::size_t r,
                            std::int32_t n, const double* value) {
  const std::int16_t* row = table + r * static_cast<std::size_t>(n_columns);
  double sum = 0;
  for (std::int32_t j = 0; j < n; ++j) sum += row[j] * scale[j] * value[j];
  return sum;
}

/// field = sum_s amount_s mode_s in float for n rows, block by block. The sums of a block stay in registers while the
/// first n_modes of its n_columns modes are read in the order of memory.
PHN_INLINE void sum_modes(std::int32_t n_modes, std::int32_t n_columns, std::int32_t n, const float* mode,
                          const float* amount, double* field) {
  const std::size_t rest = static_cast<std::size_t>(n_columns - n_modes) * rows_per_block;
  for (std::int32_t begin = 0; begin < n; begin += rows_per_block) {
    float sum[rows_per_block] = {};
    for (std::int32_t s = 0; s < n_modes; ++s, mode += rows_per_block) {
      const float factor = amount[s];
      for (std::int32_t i = 0; i < rows_per_block; ++i) sum[i] += factor * mode[i];
    }
    mode += rest;
    const std::int32_t size = n - begin < rows_per_block ? n - begin : rows_per_block;
    if (size == rows_per_block) {
      for (std::int32_t i = 0; i < rows_per_block; ++i) field[begin + i] = static_cast<double>(sum[i]);
    } else {
      for (std::int32_t i = 0; i < size; ++i) field[begin + i] = static_cast<double>(sum[i]);
    }
  }
}

/// basis_i = q(x - c_i) - q(x) minus its value at rest; then x.
PHN_INLINE void fill_basis(const SharedModes& centers, const double* x, double* __restrict basis) {
  const SharedModes shared = centers;  // a copy, for which the compiler can exclude aliasing with the results
  const double at[3] = {x[0], x[1], x[2]}, q = std::sqrt(dot(at, at) + shared.shape * shared.shape);
  for (std::int32_t i = 0; i < shared.n_centers; ++i)
    basis[i] = amplitude_kernel(shared, at, q, i) - shared.basis_at_rest[i];
  for (int k = 0; k < 3; ++k) basis[shared.n_centers + k] = at[k];
}

PHN_INLINE void fill_basis_gradient(const SharedModes& centers, const double* x, double* __restrict gradient) {
  const SharedModes shared = centers;
  const double s2 = shared.shape * shared.shape, at[3] = {x[0], x[1], x[2]}, q0 = std::sqrt(dot(at, at) + s2);
  const double rest[3] = {at[0] / q0, at[1] / q0, at[2] / q0};
  const std::int32_t n = shared.n_centers;
  double *by_x = gradient, *by_y = gradient + (n + 3), *by_z = gradient + 2 * (n + 3);
  for (std::int32_t i = 0; i < n; ++i) {
    const double y[3] = {at[0] - shared.center[0][i], at[1] - shared.center[1][i], at[2] - shared.center[2][i]};
    const double inverse = 1 / std::sqrt(dot(y, y) + s2);
    by_x[i] = y[0] * inverse - rest[0];
    by_y[i] = y[1] * inverse - rest[1];
    by_z[i] = y[2] * inverse - rest[2];
  }
  for (int k = 0; k < 3; ++k) {
    by_x[n + k] = k == 0 ? 1 : 0;
    by_y[n + k] = k == 1 ? 1 : 0;
    by_z[n + k] = k == 2 ? 1 : 0;
  }
}

/// amplitude = basis times weights for n_rows rows; each weight is converted from 16 bits once for all rows.
template <std::int32_t n_rows>
PHN_INLINE void sum_amplitudes(const ModalTables& tables, std::int32_t n_basis, const double* basis,
                               double* __restrict amplitude) {
  const std::int32_t m = tables.n_modes;
  constexpr std::int32_t block_size = 8;
  for (std::int32_t begin = 0; begin < m; begin += block_size) {
    const std::int16_t* weight = tables.weight + begin;
    const double* scale = tables.weight_scale + begin;
    double sum[n_rows][block_size] = {};
    const std::int32_t size = m - begin < block_size ? m - begin : block_size;
    if (size == block_size) {
      // Constant loop bounds let compilers vectorize the sums.
      for (std::int32_t r = 0; r < n_basis; ++r, weight += m)
        for (std::int32_t j = 0; j < block_size; ++j) {
          const double w = weight[j];
          for (std::int32_t k = 0; k < n_rows; ++k) sum[k][j] += basis[k * n_basis + r] * w;
        }
    } else {
      for (std::int32_t r = 0; r < n_basis; ++r, weight += m)
        for (std::int32_t j = 0; j < size; ++j) {
          const double w = weight[j];
          for (std::int32_t k = 0; k < n_rows; ++k) sum[k][j] += basis[k * n_basis + r] * w;
        }
    }
    for (std::int32_t k = 0; k < n_rows; ++k)
      for (std::int32_t j = 0; j < size; ++j) amplitude[k * m + begin + j] = sum[k][j] * scale[j];
  }
}

/// Nodes near the touched one, which have modes of their own. Prepared or not, the order of the products is the same.
PHN_INLINE void near_nodes(const ModalTables& tables, std::int32_t components, const PreparedNode* prepared,
                           const double* amplitude, double* field) {
  const std::int32_t n = components * tables.n_near;
  constexpr std::int32_t block_size = 12;
  for (std::int32_t begin = 0; begin < n; begin += block_size) {
    const std::int32_t size = n - begin < block_size ? n - begin : block_size;
    double sum[block_size] = {};
    if (prepared != nullptr && size == block_size) {
      for (std::int32_t j = 0; j < tables.n_modes; ++j) {
        const double* row = prepared->near_mode + static_cast<std::size_t>(j) * static_cast<std::size_t>(n) + begin;
        for (std::int32_t i = 0; i < block_size; ++i) sum[i] += row[i] * amplitude[j];
      }
    } else {
      for (std::int32_t i = 0; i < size; ++i)
        sum[i] = row_times(tables.near_mode, tables.n_columns, tables.near_mode_scale,
                           static_cast<std::size_t>(begin) + static_cast<std::size_t>(i), tables.n_modes, amplitude);
    }
    for (std::int32_t i = 0; i < size; ++i)
      field[components * tables.near[(begin + i) / components] + i % components] = sum[i];
  }
}

PHN_INLINE void sum_field(const SharedTable& shared, const ModalTables& tables, const PreparedNode* prepared,
                          const double* amplitude, double* scratch, double* field) {
  const std::int32_t m = tables.n_modes;
  auto* amount = reinterpret_cast<float*>(scratch);
  if (prepared != nullptr) {
    for (std::int32_t j = 0; j < m; ++j) amount[j] = static_cast<float>(amplitude[j]);
    sum_modes(m, tables.n_columns, shared.n_rows, prepared->modes, amount, field);
  } else {
    for (std::int32_t s = 0; s < shared.n_modes; ++s)
      amount[s] = static_cast<float>(
          row_times(tables.mixing, tables.n_columns, tables.mixing_scale, static_cast<std::size_t>(s), m, amplitude));
    sum_modes(shared.n_modes, shared.n_modes, shared.n_rows, shared.modes, amount, field);
  }
  // Compilers divide faster by constants; block_size is a multiple of both.
  if (shared.components == 3) return near_nodes(tables, 3, prepared, amplitude, field);
  near_nodes(tables, 1, prepared, amplitude, field);
}

/// Product of shared modes and mixing for one block of rows.
PHN_INLINE void mix_block(const SharedTable& shared, const ModalTables& tables, const float* block, float* out) {
  for (std::int32_t j = 0; j < tables.n_modes; ++j, out += rows_per_block) {
    float sum[rows_per_block] = {};
    const auto scale = static_cast<float>(tables.mixing_scale[j]);
    const std::int16_t* mixing = tables.mixing + j;
    const float* mode = block;
    for (std::int32_t s = 0; s < shared.n_modes; ++s, mode += rows_per_block, mixing += tables.n_modes) {
      const auto factor = static_cast<float>(*mixing);
      for (std::int32_t i = 0; i < rows_per_block; ++i) sum[i] += factor * mode[i];
    }
    for (std::int32_t i = 0; i < rows_per_block; ++i) out[i] = scale * sum[i];
  }
}

#define PHN_MODAL_KERNELS(name, bytes, attributes)                                                                     \
  namespace name {                                                                                                     \
  attributes void basis(const SharedModes& shared, const double* x, double* values) { fill_basis(shared, x, values); } \
  attributes void basis_gradient(const SharedModes& shared, const double* x, double* values) {                         \
    fill_basis_gradient(shared, x, values);                                                                            \
  }                                                                                                                    \
  attributes void amplitudes(const ModalTables& tables, std::int32_t n_basis, const double* values,                    \
                             double* amplitude) {                                                                      \
    sum_amplitudes<1>(tables, n_basis, values, amplitude);                                                             \
  }                                                                                                                    \
  attributes void three_amplitudes(const ModalTables& tables, std::int32_t n_basis, const double* values,              \
                                   double* amplitude) {                                                                \
    sum_amplitudes<3>(tables, n_basis, values, amplitude);                                                             \
  }                                                                                                                    \
  attributes void field(const SharedTable& shared, const ModalTables& tables, const PreparedNode* prepared,            \
                        const double* amplitude, double* scratch, double* values) {                                    \
    sum_field(shared, tables, prepared, amplitude, scratch, values);                                                   \
  }                                                                                                                    \
  attributes void sum_block(const SharedTable& shared, const ModalTables& tables, const float* block, float* out) {    \
    mix_block(shared, tables, block, out);                                                                             \
  }                                                                                                                    \
  constexpr ModalKernels kernels = {#name, basis, basis_gradient, amplitudes, three_amplitudes, field, sum_block};     \
  }

PHN_FOR_EACH_SET(PHN_MODAL_KERNELS, ModalKernels)

}  // namespace

const ModalKernels* modal_kernels(int set) { return kernels_for(kernels_of_sets, set); }
const ModalKernels& best_modal_kernels() { return best_of(kernels_of_sets); }

}  // namespace PHN_RUNTIME
