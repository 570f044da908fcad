#include "modal.hpp"

#include <cmath>

namespace phynness::runtime {

void scaled_displacement(double max_displacement, const double* d, double* x) {
  for (int k = 0; k < 3; ++k)
    x[k] = std::fmax(-largest_modal, std::fmin(largest_modal, d[k] / max_displacement));
}

namespace {

/// Row r of a table of n columns times a vector.
double row_times(const std::int16_t* table, const double* scale, std::size_t r, std::int32_t n,
                 const double* value) {
  const std::int16_t* row = table + r * static_cast<std::size_t>(n);
  double sum = 0;
  for (std::int32_t j = 0; j < n; ++j) sum += row[j] * scale[j] * value[j];
  return sum;
}

/// field = sum_s amount_s mode_s in float, a block of rows at a time: its sums stay in registers while the
/// modes stream by in the order of memory.
void add_shared_modes(const float* mode, std::int32_t n_modes, std::int32_t n, const float* amount,
                      double* field) {
  for (std::int32_t begin = 0; begin < n; begin += rows_per_block) {
    float sum[rows_per_block] = {};
    for (std::int32_t s = 0; s < n_modes; ++s, mode += rows_per_block) {
      const float factor = amount[s];
      for (std::int32_t i = 0; i < rows_per_block; ++i) sum[i] += factor * mode[i];
    }
    const std::int32_t size = n - begin < rows_per_block ? n - begin : rows_per_block;
    for (std::int32_t i = 0; i < size; ++i) field[begin + i] = static_cast<double>(sum[i]);
  }
}

}  // namespace

void modal_force(const ModalResponse& node, const double* d, double* force) {
  double x[3];
  scaled_displacement(node.force.max_displacement, d, x);
  conservative_force(node.force, x, force);
}

double modal_energy(const ModalResponse& node, const double* d) {
  double x[3];
  scaled_displacement(node.force.max_displacement, d, x);
  return conservative_energy(node.force, x);
}

void modal_stiffness(const ModalResponse& node, const double* d, double* stiffness) {
  double x[3];
  scaled_displacement(node.force.max_displacement, d, x);
  conservative_stiffness(node.force, x, stiffness);
}

void modal_amplitudes(const ModalTables& tables, const double* basis, std::int32_t n_basis,
                      double* amplitude) {
  const std::int32_t m = tables.n_modes;
  for (std::int32_t j = 0; j < m; ++j) amplitude[j] = 0;
  for (std::int32_t r = 0; r < n_basis; ++r) {
    const std::int16_t* row = tables.weight + static_cast<std::size_t>(r) * static_cast<std::size_t>(m);
    for (std::int32_t j = 0; j < m; ++j) amplitude[j] += basis[r] * row[j];
  }
  for (std::int32_t j = 0; j < m; ++j) amplitude[j] *= tables.weight_scale[j];
}

void modal_sum(const ModalTables& tables, const float* shared, std::int32_t n_shared, std::int32_t components,
               std::int32_t n_output, const double* amplitude, float* amount, double* out) {
  const std::int32_t m = tables.n_modes;
  for (std::int32_t s = 0; s < n_shared; ++s)
    amount[s] = static_cast<float>(
        row_times(tables.mixing, tables.mixing_scale, static_cast<std::size_t>(s), m, amplitude));
  add_shared_modes(shared, n_shared, components * n_output, amount, out);
  for (std::int32_t i = 0; i < tables.n_near; ++i) {
    for (std::int32_t k = 0; k < components; ++k)
      out[components * tables.near[i] + k] = row_times(
          tables.near_mode, tables.near_mode_scale,
          static_cast<std::size_t>(components) * static_cast<std::size_t>(i) + static_cast<std::size_t>(k), m,
          amplitude);
  }
}

}  // namespace phynness::runtime
