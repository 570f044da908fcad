#include "prepared.hpp"

#include "coupled.hpp"
#include "modal_kernels.hpp"

namespace phynness::runtime {
namespace {

/// A node is ready after so many deformations.
constexpr std::int32_t calls_to_ready = 16;

void turn_near_modes(const ModalResponse& node, PreparedNode& entry) {
  const auto m = static_cast<std::size_t>(node.n_modes), n_rows = 3 * static_cast<std::size_t>(node.n_near);
  for (std::size_t r = 0; r < n_rows; ++r) {
    for (std::size_t j = 0; j < m; ++j)
      entry.near_mode[j * n_rows + r] = node.near_mode[r * m + j] * node.near_mode_scale[j];
  }
}

void make_ready(const phn_model& model, PreparedNode& entry, std::int32_t n_more) {
  const ModalResponse& node = *model.active[entry.active].modal;
  const std::int32_t n_blocks = block_count(model);
  const auto sum_block = best_modal_kernels().sum_block;
  if (entry.n_blocks == 0) turn_near_modes(node, entry);
  for (; entry.n_blocks < n_blocks && n_more > 0; ++entry.n_blocks, --n_more) {
    const auto first = static_cast<std::size_t>(entry.n_blocks) * rows_per_block;
    sum_block(model.shared, node, model.shared.modes + first * static_cast<std::size_t>(model.shared.n_modes),
              entry.modes + first * static_cast<std::size_t>(node.n_modes));
  }
}

PreparedNode* find_or_replace(const phn_model& model, PreparedNodes& prepared, std::int32_t active, bool& known) {
  if (prepared.n == 0 || !worth_preparing(model.shared, *model.active[active].modal)) return nullptr;
  PreparedNode *found = nullptr, *oldest = prepared.node;
  for (std::int32_t i = 0; i < prepared.n && found == nullptr; ++i) {
    PreparedNode& entry = prepared.node[i];
    if (entry.active == active) found = &entry;
    if (entry.touched < oldest->touched) oldest = &entry;
  }
  known = found != nullptr;
  if (!known) {
    found = oldest;
    found->active = active;
    found->n_blocks = 0;
  }
  found->touched = ++prepared.now;
  return found;
}

}  // namespace

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  PreparedNodes prepared = {0, 0, nullptr};
  if (model.prepared_modes == 0) return prepared;
  prepared.n = 3 * (max_tools < most_coupled ? max_tools : most_coupled);
  prepared.node = arena.take<PreparedNode>(static_cast<std::size_t>(prepared.n));
  const auto m = static_cast<std::size_t>(model.prepared_modes);
  for (std::int32_t i = 0; i < prepared.n; ++i) {
    PreparedNode entry = {-1, 0, 0, nullptr, nullptr};
    entry.near_mode = arena.take<double>(model.prepared_near);
    entry.modes = arena.take<float>(static_cast<std::size_t>(block_count(model)) * rows_per_block * m);
    if (prepared.node) prepared.node[i] = entry;
  }
  return prepared;
}

const PreparedNode* touch(const phn_model& model, PreparedNodes& prepared, std::int32_t active) {
  bool known = false;
  PreparedNode* entry = find_or_replace(model, prepared, active, known);
  // A node that is touched once, and then another, costs nothing extra.
  if (entry != nullptr && known)
    make_ready(model, *entry, (block_count(model) + calls_to_ready - 1) / calls_to_ready);
  return entry;
}

void prepare(const phn_model& model, PreparedNodes& prepared, std::int32_t active) {
  bool known = false;
  PreparedNode* entry = find_or_replace(model, prepared, active, known);
  if (entry != nullptr) make_ready(model, *entry, block_count(model));
}

}  // namespace phynness::runtime
