#include "core/load_stores.hpp"

#include <cfloat>

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Memory for n numbers, padded with zeros to whole blocks.
double* blocks(Load& load, std::int64_t n) {
  const std::int32_t n_whole = whole_blocks(static_cast<std::int32_t>(n));
  auto* at = load.arena.take<double>(static_cast<std::size_t>(n_whole));
  for (std::int64_t i = n; load.has_memory() && i < n_whole; ++i) at[i] = 0;
  return at;
}

bool same_depths(TextReader a, TextReader b, std::int64_t n) {
  for (std::int64_t i = 0; i < n; ++i) {
    if (a.real() != b.real()) return false;
    a.end_line();
    b.end_line();
    if (!a.good() || !b.good()) return false;
  }
  return true;
}

/// Whether all coefficients in the following n lines of centers are exact in float.
bool coefficients_are_floats(TextReader in, std::int64_t n) {
  for (std::int64_t i = 0; i < n; ++i) {
    in.integer(0, INT32_MAX);
    for (int k = 0; k < 3; ++k) {
      const double value = in.real();
      if (!(std::fabs(value) <= FLT_MAX) || static_cast<double>(static_cast<float>(value)) != value) return false;
    }
    in.end_line();
    if (!in.good()) return false;
  }
  return true;
}

/// Whether a row of the displacements is within largest_center. Without memory the result is true.
bool near_enough(const phn_model& model, std::int32_t row) {
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
  at[3 * i + k] = vertex;
}

void Depths::shape(Load& load, std::int64_t rows, std::int64_t) {
  const bool same = known.n == rows && same_depths(load.in, known.text, rows);
  known.text = load.in;
  known.n = static_cast<std::int32_t>(rows);
  own = same ? nullptr : load.arena.take<double>(static_cast<std::size_t>(rows));
  if (!same) known.values = own;
}

void Depths::set(Load&, std::int64_t i, std::int64_t, double value) {
  known.least = i == 0 ? value : std::fmin(value, known.least);
  if (own != nullptr) own[i] = value;
}

void Centers::shape(Load& load, std::int64_t rows, std::int64_t) {
  for (int k = 0; k < 3; ++k) net.center[first_input + k] = at[k] = blocks(load, rows);
}

void Centers::set(Load& load, std::int64_t i, std::int64_t, std::int32_t row) {
  if (!load.has_memory()) return;
  const double* table = first_input == 0 ? load.model.displacements : load.model.output_points;
  for (int k = 0; k < 3; ++k) {
    const int input = first_input + k;
    const double scaled = (table[3 * row + k] - net.input_center[input]) / net.input_half_range[input];
    load.require(std::isfinite(scaled));
    at[k][i] = scaled;
  }
}

void Weights::shape(Load& load, std::int64_t rows, std::int64_t) {
  net.n_neurons = static_cast<std::int32_t>(rows);
  for (int k = 0; k < 3; ++k) net.weight[k] = at[k] = blocks(load, rows);
}

void LinearStore::UnitResponses::shape(Load& load, std::int64_t rows, std::int64_t) {
  for (int k = 0; k < 3; ++k) made[k] = at[k] = load.arena.take<double>(static_cast<std::size_t>(rows), 3);
}

void SharedTableStore::Entries::shape(Load& load, std::int64_t rows, std::int64_t cols) {
  n = rows;
  n_cols = cols;
  constexpr std::int64_t block = rows_per_block;
  const auto n_values = static_cast<std::size_t>((rows + block - 1) / block * block * cols);
  at = load.arena.take<float>(load.in.good() ? n_values : 0);
  for (std::size_t i = 0; load.has_memory() && load.in.good() && i < n_values; ++i) at[i] = 0;  // pads the last block
}

void AmplitudeCenters::shape(Load& load, std::int64_t rows, std::int64_t) {
  n = rows;
  for (auto& component : at) component = load.arena.take<double>(static_cast<std::size_t>(rows));
  at_rest = load.arena.take<double>(static_cast<std::size_t>(rows));
}

void AmplitudeCenters::set(Load& load, std::int64_t i, std::int64_t, std::int32_t row) {
  load.require(near_enough(load.model, row));
  for (int k = 0; k < 3 && load.has_memory(); ++k)
    at[k][i] = load.model.displacements[3 * static_cast<std::size_t>(row) + k];
}

void AmplitudeCenters::make(Load& load, SharedModes& shared) const {
  shared.n_centers = static_cast<std::int32_t>(n);
  for (int k = 0; k < 3; ++k) shared.center[k] = at[k];
  shared.basis_at_rest = at_rest;
  if (!load.has_memory() || !load.in.good()) return;
  // Computed by the same function as the kernels themselves, so that amplitudes at rest are exactly 0.
  const double rest[3] = {0, 0, 0}, q = std::sqrt(dot(rest, rest) + shared.shape * shared.shape);
  for (std::int32_t i = 0; i < shared.n_centers; ++i) at_rest[i] = amplitude_kernel(shared, rest, q, i);
}

void ForceCenters::set(Load& load, std::int64_t i, std::int64_t, std::int32_t row) {
  load.require(near_enough(load.model, row));
  if (at) at[i] = row;
}

void Coefficients::shape(Load& load, std::int64_t rows, std::int64_t cols) {
  const bool floats = coefficients_are_floats(load.in, rows);
  const auto n = static_cast<std::size_t>(rows * cols);
  short_values = load.arena.take<float>(floats ? n : 0);
  values = load.arena.take<double>(floats ? 0 : n);
  if (floats) values = nullptr;
  if (!floats) short_values = nullptr;
  made.short_coefficient = short_values;
  made.coefficient = values;
}

}  // namespace PHN_RUNTIME
