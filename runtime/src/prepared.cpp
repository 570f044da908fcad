#include "prepared.hpp"

#include "coupled.hpp"
#include "modal_kernels.hpp"
#include "network_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// Rows of all modes, whole blocks.
std::size_t row_count(const phn_model& model) {
  constexpr std::size_t rows = rows_per_block;
  return (static_cast<std::size_t>(model.shared.n_rows) + rows - 1) / rows * rows;
}

/// Output nodes in whole blocks.
std::size_t node_count(const phn_model& model) {
  constexpr std::size_t nodes = nodes_per_block;
  return (static_cast<std::size_t>(model.n_output) + nodes - 1) / nodes * nodes;
}

void fill_modes(const phn_model& model, PreparedNode& entry) {
  const ModalResponse& node = *model.active[entry.active].modal;
  const auto m = static_cast<std::size_t>(node.n_modes), n_shared = static_cast<std::size_t>(model.shared.n_modes);
  const ModalKernels& kernels = best_modal_kernels();
  for (std::size_t row = 0; row < row_count(model); row += rows_per_block)
    kernels.sum_block(model.shared, node, model.shared.modes + row * n_shared, entry.modes + row * m);
  const std::size_t n_near = 3 * static_cast<std::size_t>(node.n_near);
  for (std::size_t r = 0; r < n_near; ++r) {
    for (std::size_t j = 0; j < m; ++j)
      entry.near_mode[j * n_near + r] = node.near_mode[r * m + j] * node.near_mode_scale[j];
  }
}

void fill(const phn_model& model, PreparedNode& entry) {
  if (model.family == Family::modal) return fill_modes(model, entry);
  best_network_kernels().of_coordinates(model.active[entry.active].networks->deformation, model.n_output,
                                        model.output_points, entry.gaussians);
}

bool worth_preparing(const phn_model& model, std::int32_t active) {
  return model.family == Family::rbfn || worth_preparing(model.shared, *model.active[active].modal);
}

}  // namespace

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  PreparedNodes prepared = {0, 0, nullptr};
  if (model.family != Family::rbfn && model.prepared_modes == 0) return prepared;
  prepared.n = 3 * (max_tools < most_coupled ? max_tools : most_coupled);
  prepared.node = arena.take<PreparedNode>(static_cast<std::size_t>(prepared.n));
  const auto m = static_cast<std::size_t>(model.prepared_modes);
  for (std::int32_t i = 0; i < prepared.n; ++i) {
    PreparedNode entry = {-1, 0, nullptr, nullptr, nullptr};
    if (model.family == Family::rbfn) {
      entry.gaussians = arena.take<Real>(node_count(model), model.n_basis);
    } else {
      entry.near_mode = arena.take<double>(model.prepared_near);
      entry.modes = arena.take<float>(row_count(model), m);
    }
    if (prepared.node) prepared.node[i] = entry;
  }
  return prepared;
}

const PreparedNode* prepare(const phn_model& of_level, PreparedNodes& prepared, std::int32_t active) {
  const phn_model& model = *of_level.full;
  if (prepared.n == 0 || !worth_preparing(model, active)) return nullptr;
  PreparedNode *found = nullptr, *oldest = prepared.node;
  for (std::int32_t i = 0; i < prepared.n && found == nullptr; ++i) {
    PreparedNode& entry = prepared.node[i];
    if (entry.active == active) found = &entry;
    if (entry.touched < oldest->touched) oldest = &entry;
  }
  if (found == nullptr) {
    found = oldest;
    found->active = active;
    fill(model, *found);
  }
  found->touched = ++prepared.now;
  return found;
}

}  // namespace PHN_RUNTIME
