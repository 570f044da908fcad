#include "core/load_stores.hpp"

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Memory for n numbers, padded with zeros to whole blocks.
double* blocks(Load& load, std::int64_t n) {
  const std::int32_t n_whole = whole_blocks(static_cast<std::int32_t>(n));
  auto* data = load.arena.take<double>(static_cast<std::size_t>(n_whole));
  for (std::int64_t i = n; load.has_memory() && i < n_whole; ++i) data[i] = 0;
  return data;
}

/// Whether a row of the displacements is within largest_center. Without memory the result is true.
bool is_in_center_range(const phn_model& model, std::int32_t row) {
  bool near = true;
  for (int k = 0; k < 3 && model.displacements; ++k)
    near = near && std::fabs(model.displacements[3 * static_cast<std::size_t>(row) + k]) <= largest_center;
  return near;
}

}  // namespace

void Corners::set(Load& load, std::int64_t i, std::int64_t k, std::int32_t node) {
  if (!load.has_memory()) return;
  const std::int32_t vertex = find_vertex(load.model, node);
  load.require(vertex >= 0);
  data[3 * i + k] = vertex;
}

void Centers::shape(Load& load, std::int64_t rows, std::int64_t) {
  for (int k = 0; k < 3; ++k) net.center[first_input + k] = data[k] = blocks(load, rows);
}

void Centers::set(Load& load, std::int64_t i, std::int64_t, std::int32_t row) {
  if (!load.has_memory()) return;
  const double* table = first_input == 0 ? load.model.displacements : load.model.output_points;
  for (int k = 0; k < 3; ++k) {
    const int input = first_input + k;
    const double scaled = (table[3 * row + k] - net.input_center[input]) / net.input_half_range[input];
    load.require(std::isfinite(scaled));
    data[k][i] = scaled;
  }
}

void Weights::shape(Load& load, std::int64_t rows, std::int64_t) {
  net.n_neurons = static_cast<std::int32_t>(rows);
  for (int k = 0; k < 3; ++k) net.weight[k] = data[k] = blocks(load, rows);
}

void LinearStore::UnitResponses::shape(Load& load, std::int64_t rows, std::int64_t) {
  for (int k = 0; k < 3; ++k) made[k] = data[k] = load.arena.take<double>(static_cast<std::size_t>(rows), 3);
}

void SharedTableStore::Entries::shape(Load& load, std::int64_t rows, std::int64_t cols) {
  n = rows;
  n_cols = cols;
  constexpr std::int64_t block = rows_per_block;
  const auto n_values = static_cast<std::size_t>((rows + block - 1) / block * block * cols);
  data = load.arena.take<float>(load.in.good() ? n_values : 0);
  for (std::size_t i = 0; load.has_memory() && load.in.good() && i < n_values; ++i) data[i] = 0;  // pads the last block
}

void AmplitudeCenters::shape(Load& load, std::int64_t rows, std::int64_t) {
  n = rows;
  for (auto& component : data) component = load.arena.take<double>(static_cast<std::size_t>(rows));
  at_rest = load.arena.take<double>(static_cast<std::size_t>(rows));
}

void AmplitudeCenters::set(Load& load, std::int64_t i, std::int64_t, std::int32_t row) {
  load.require(is_in_center_range(load.model, row));
  for (int k = 0; k < 3 && load.has_memory(); ++k)
    data[k][i] = load.model.displacements[3 * static_cast<std::size_t>(row) + k];
}

void AmplitudeCenters::make(Load& load, SharedModes& shared) const {
  shared.n_centers = static_cast<std::int32_t>(n);
  for (int k = 0; k < 3; ++k) shared.center[k] = data[k];
  shared.basis_at_rest = at_rest;
  if (!load.has_memory() || !load.in.good()) return;
  // Computed by the same function as the kernels themselves, so that amplitudes at rest are exactly 0.
  const double rest[3] = {0, 0, 0}, q = std::sqrt(dot(rest, rest) + shared.shape * shared.shape);
  for (std::int32_t i = 0; i < shared.n_centers; ++i) at_rest[i] = amplitude_kernel(shared, rest, q, i);
}

void ForceCenters::shape(Load& load, std::int64_t rows, std::int64_t) {
  force.n_centers = static_cast<std::int32_t>(rows);
  n_whole = whole_blocks(force.n_centers + 1);
  force.table = terms = load.arena.take<double>(6, static_cast<std::size_t>(n_whole));
  for (std::int32_t i = 0; load.has_memory() && i < 6 * n_whole; ++i) terms[i] = 0;
}

void ForceCenters::set(Load& load, std::int64_t i, std::int64_t, std::int32_t row) {
  load.require(is_in_center_range(load.model, row));
  for (int k = 0; k < 3 && load.has_memory(); ++k)
    terms[k * n_whole + i] = load.model.displacements[3 * static_cast<std::size_t>(row) + k];
}

}  // namespace PHN_RUNTIME
