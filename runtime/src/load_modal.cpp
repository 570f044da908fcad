// The parts of model.txt that only family modal has.
#include <cfloat>

#include "load_parts.hpp"
#include "modal_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr std::int32_t largest_mode_count = 1024, largest_entry = 32767;
constexpr double largest_table_value = 1e6;

std::int32_t mode_count_line(TextReader& in, const char* keyword) {
  in.keyword(keyword);
  const std::int32_t n = in.integer(0, largest_mode_count);
  in.end_line();
  return n;
}

/// Keyword and scales of a table, whose n_rows x n_columns entries have to fit into the rest of the text.
const double* table_scale(TextReader& in, Arena& arena, const char* keyword, std::uint64_t n_rows,
                          std::int32_t n_columns) {
  in.keyword(keyword);
  Column<double> scale(arena, n_columns);
  for (std::int32_t c = 0; c < n_columns && in.good(); ++c) {
    const double value = in.real();
    if (!(value >= 0 && value * largest_entry <= largest_table_value)) in.fail(PHN_ERROR_RANGE);
    scale.set(c, value);
  }
  in.end_line();
  in.require_room(n_rows * static_cast<std::uint64_t>(n_columns));
  return scale.get();
}

/// store(row, column, entry) for all of a table.
template <class Store>
void table_entries(TextReader& in, std::size_t n_rows, std::int32_t n_columns, Store store) {
  for (std::size_t r = 0; r < n_rows && n_columns > 0 && in.good(); ++r) {
    for (std::int32_t c = 0; c < n_columns; ++c) store(r, c, in.integer(-largest_entry, largest_entry));
    in.end_line();
  }
}

const std::int16_t* table(TextReader& in, Arena& arena, const char* keyword, std::size_t n_rows,
                          std::int32_t n_columns, const double*& scale) {
  scale = table_scale(in, arena, keyword, n_rows, n_columns);
  const auto columns = static_cast<std::size_t>(n_columns);
  Column<std::int16_t> entries(arena, in.good() ? n_rows * columns : 0);
  table_entries(in, n_rows, n_columns, [&](std::size_t r, std::int32_t c, std::int32_t entry) {
    entries.set(r * columns + static_cast<std::size_t>(c), static_cast<std::int16_t>(entry));
  });
  return entries.get();
}

/// A row of the displacements, which must not lie absurdly far away. Without memory there is nothing to look
/// at.
std::int32_t center(TextReader& in, std::int32_t n_displacements, const phn_model& model) {
  const std::int32_t row = in.integer(0, n_displacements - 1);
  for (int k = 0; k < 3 && model.displacements && in.good(); ++k) {
    if (!(std::fabs(model.displacements[3 * static_cast<std::size_t>(row) + k]) <= largest_center))
      in.fail(PHN_ERROR_RANGE);
  }
  return row;
}

/// Whether the n lines of centers that follow hold coefficients that a float holds exactly.
bool coefficients_are_floats(TextReader in, std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) {
    in.integer(0, INT32_MAX);
    for (int k = 0; k < 3; ++k) {
      const double value = in.real();
      if (!(std::fabs(value) <= FLT_MAX) || static_cast<double>(static_cast<float>(value)) != value)
        return false;
    }
    in.end_line();
    if (!in.good()) return false;
  }
  return true;
}

/// Centers and coefficients once more as the force reads them, and what makes forces at rest 0.
void place_force_table(Arena& arena, Conservative<double>& net, ForceTable& table, bool good) {
  const bool in_table = net.n_centers > most_gathered;
  auto* centers = arena.take<Real>(in_table ? 6 * static_cast<std::size_t>(whole_blocks(net.n_centers + 1)) : 0);
  table.centers = in_table ? centers : nullptr;
  if (!has_memory(arena) || !good) return;
  // The function that adds these values computes them: zeros at rest are exact.
  const auto by_kernel = [&](const Conservative<double>& unit, const double* at, double* force) {
    for (double& f : table.at_rest) f = 0;
    if (in_table) fill_force_table(unit, centers);
    best_modal_kernels().force(unit, table, at, force);
  };
#ifdef PHYNNESS_FLOAT
  const double rest[3] = {0, 0, 0};
  double force[3];
  set_rest(net);
  by_kernel(net, rest, force);
  for (int k = 0; k < 3; ++k) table.at_rest[k] = -force[k];
#else
  set_rest(net, by_kernel);
  for (int k = 0; k < 3; ++k) table.at_rest[k] = net.force_at_rest[k];
#endif
}

void load_conservative(TextReader& in, Arena& arena, std::int32_t n_displacements, const phn_model& model,
                       Conservative<double>& net, ForceTable& table) {
  const std::int32_t n = net.n_centers = count_line(in, "force", 0);
  net.max_displacement = model.max_displacement;
  net.displacements = model.displacements;
  net.shape = width_line(in, "shape");
  stiffness_line(in, net.stiffness);
  const bool floats = coefficients_are_floats(in, n);
  const std::size_t n_values = 3 * static_cast<std::size_t>(n);
  Column<std::int32_t> centers(arena, n);
  Column<float> short_values(arena, floats ? n_values : 0);
  Column<double> values(arena, floats ? 0 : n_values);
  double size = 0;
  for (std::int32_t i = 0; i < n && in.good(); ++i) {
    centers.set(i, center(in, n_displacements, model));
    for (int k = 0; k < 3; ++k) {
      const double value = linear_entry(in);
      size += std::fabs(value);
      if (!(std::fabs(value) <= largest_weight && size <= largest_weight_sum)) in.fail(PHN_ERROR_RANGE);
      if (floats) {
        short_values.set(3 * static_cast<std::size_t>(i) + k, static_cast<float>(value));
      } else {
        values.set(3 * static_cast<std::size_t>(i) + k, value);
      }
    }
    in.end_line();
  }
  net.center = centers.get();
  net.short_coefficient = floats ? short_values.get() : nullptr;
  net.coefficient = floats ? nullptr : values.get();
  place_force_table(arena, net, table, in.good());
}

}  // namespace

void load_shared_table(TextReader& in, Arena& arena, std::int32_t n_output, std::int32_t components,
                       SharedTable& shared) {
  shared.components = components;
  shared.n_rows = components * n_output;
  shared.n_modes = mode_count_line(in, "shared_modes");
  const auto n_rows = static_cast<std::size_t>(shared.n_rows), columns = static_cast<std::size_t>(shared.n_modes);
  const double* scale = table_scale(in, arena, "modes", n_rows, shared.n_modes);
  constexpr auto rows = static_cast<std::size_t>(rows_per_block);
  const std::size_t n_blocks = (n_rows + rows - 1) / rows;
  const std::size_t n_values = in.good() ? n_blocks * columns * rows : 0;
  Column<float> modes(arena, n_values);
  const bool fill = has_memory(arena);
  for (std::size_t i = 0; i < n_values; ++i) modes.set(i, 0.0f);  // what fills the last block up
  table_entries(in, n_rows, shared.n_modes, [&](std::size_t r, std::int32_t c, std::int32_t entry) {
    if (fill)
      modes.set(((r / rows) * columns + static_cast<std::size_t>(c)) * rows + r % rows,
                static_cast<float>(scale[c] * entry));
  });
  shared.modes = modes.get();
}

void load_amplitude_centers(TextReader& in, Arena& arena, std::int32_t n_displacements, const phn_model& model,
                            SharedModes& shared) {
  double* centers[3];
  for (int k = 0; k < 3; ++k)
    shared.center[k] = centers[k] = arena.take<double>(static_cast<std::size_t>(shared.n_centers));
  auto* at_rest = arena.take<double>(static_cast<std::size_t>(shared.n_centers));
  shared.basis_at_rest = at_rest;
  const bool place_centers = has_memory(arena);
  for (std::int32_t i = 0; i < shared.n_centers && in.good(); ++i) {
    const std::int32_t row = center(in, n_displacements, model);
    for (int k = 0; k < 3 && place_centers; ++k)
      centers[k][i] = model.displacements[3 * static_cast<std::size_t>(row) + k];
    in.end_line();
  }
  if (!place_centers || !in.good()) return;
  // The function from which these values are subtracted computes them: amplitudes at rest are exactly 0.
  const double rest[3] = {0, 0, 0}, q = std::sqrt(dot(rest, rest) + shared.shape * shared.shape);
  for (std::int32_t i = 0; i < shared.n_centers; ++i) at_rest[i] = amplitude_kernel(shared, rest, q, i);
}

void load_shared(TextReader& in, Arena& arena, std::int32_t n_displacements, phn_model& model) {
  SharedModes& shared = model.shared;
  load_shared_table(in, arena, model.n_output, 3, shared);
  shared.n_centers = count_line(in, "amplitude_centers", 0);
  shared.shape = width_line(in, "shape");
  load_amplitude_centers(in, arena, n_displacements, model, shared);
}

void load_tables(TextReader& in, Arena& arena, const char* keyword, std::size_t n_kernels,
                 const SharedTable& shared, std::int32_t n_output, ModalTables& tables) {
  const std::int32_t m = tables.n_modes = mode_count_line(in, keyword);
  tables.n_columns = m;
  tables.weight = table(in, arena, "weights", n_kernels, m, tables.weight_scale);
  tables.mixing = table(in, arena, "mixing", static_cast<std::size_t>(shared.n_modes), m, tables.mixing_scale);
  tables.n_near = count_line(in, "near", 0);
  Column<std::int32_t> near(arena, tables.n_near);
  std::int32_t previous = -1;
  for (std::int32_t i = 0; i < tables.n_near && in.good(); ++i) {
    const std::int32_t position = in.integer(0, n_output - 1);
    if (position <= previous) in.fail(PHN_ERROR_RANGE);
    near.set(i, previous = position);
    in.end_line();
  }
  tables.near = near.get();
  const std::size_t n_near_rows = static_cast<std::size_t>(shared.components) * static_cast<std::size_t>(tables.n_near);
  tables.near_mode = table(in, arena, "near_modes", n_near_rows, m, tables.near_mode_scale);
}

LoadedModal load_modal(TextReader& in, Arena& arena, std::int32_t n_displacements, phn_model& model) {
  LoadedModal node = {};
  load_conservative(in, arena, n_displacements, model, node.force, node.force_table);
  load_tables(in, arena, "deformation", static_cast<std::size_t>(model.shared.n_centers) + 3,
              model.shared, model.n_output, node);
  const auto n_modes = static_cast<std::size_t>(node.n_modes);
  model.n_basis = model.n_basis > n_modes ? model.n_basis : n_modes;
  if (worth_preparing(model.shared, node)) {
    const std::size_t n_near_values = 3 * static_cast<std::size_t>(node.n_near) * n_modes;
    model.prepared_modes = model.prepared_modes > node.n_modes ? model.prepared_modes : node.n_modes;
    model.prepared_near = model.prepared_near > n_near_values ? model.prepared_near : n_near_values;
  }
  load_node_fields(in, arena, model, node);
  return node;
}

void load_level_weights(TextReader& in, Arena& arena, const char* keyword, std::size_t n_kernels, ModalTables& tables) {
  in.keyword(keyword);
  // A node has modes at every level or at none.
  tables.n_modes = in.integer(tables.n_columns > 0 ? 1 : 0, tables.n_columns);
  in.end_line();
  tables.weight = table(in, arena, "weights", n_kernels, tables.n_modes, tables.weight_scale);
}

ModalResponse load_modal_level(TextReader& in, Arena& arena, std::int32_t n_displacements, const phn_model& level,
                               const LoadedModal& full) {
  ModalResponse node = full;
  load_conservative(in, arena, n_displacements, level, node.force, node.force_table);
  if (node.force.n_centers > full.force.n_centers) in.fail(PHN_ERROR_RANGE);
  load_level_weights(in, arena, "deformation", static_cast<std::size_t>(level.shared.n_centers) + 3, node);
  node.fields = load_level_fields(in, arena, level, full);
  return node;
}

}  // namespace PHN_RUNTIME
