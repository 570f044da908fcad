#include "prepared.hpp"

#include "coupled.hpp"
#include "families.hpp"
#include "rbfn/network_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// Number of output nodes, rounded up to whole blocks.
std::size_t node_count(const phn_model& model) {
  constexpr std::size_t nodes = nodes_per_block;
  return (static_cast<std::size_t>(model.n_output) + nodes - 1) / nodes * nodes;
}

}  // namespace

std::size_t prepared_rows(const phn_model& model) {
  constexpr std::size_t rows = rows_per_block;
  return (static_cast<std::size_t>(model.shared.n_rows) + rows - 1) / rows * rows;
}

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  PreparedNodes prepared = {0, 0, nullptr};
  if (model.prepared_neurons == 0 && model.prepared_modes == 0) return prepared;
  prepared.n = 3 * (max_tools < most_coupled ? max_tools : most_coupled);
  prepared.node = arena.take<PreparedNode>(static_cast<std::size_t>(prepared.n));
  const auto m = static_cast<std::size_t>(model.prepared_modes);
  for (std::int32_t i = 0; i < prepared.n; ++i) {
    PreparedNode entry = {-1, 0, nullptr, nullptr, nullptr};
    if (model.prepared_neurons > 0) entry.gaussians = arena.take<Real>(node_count(model), model.prepared_neurons);
    if (model.prepared_modes > 0) {
      entry.near_mode = arena.take<double>(model.prepared_near);
      entry.modes = arena.take<float>(prepared_rows(model), m);
    }
    if (prepared.node) prepared.node[i] = entry;
  }
  return prepared;
}

const PreparedNode* prepare(const phn_model& of_level, PreparedNodes& prepared, std::int32_t active) {
  const phn_model& model = *of_level.full;
  const ActiveNode& node = model.active[active];
  const auto worth = [&](const auto& response) { return worth_preparing(model, response); };
  if (prepared.n == 0 || !with_response(model, node, worth)) return nullptr;
  PreparedNode *found = nullptr, *oldest = prepared.node;
  for (std::int32_t i = 0; i < prepared.n && found == nullptr; ++i) {
    PreparedNode& entry = prepared.node[i];
    if (entry.active == active) found = &entry;
    if (entry.touched < oldest->touched) oldest = &entry;
  }
  if (found == nullptr) {
    found = oldest;
    found->active = active;
    with_response(model, node, [&](const auto& response) { prepare_response(model, response, *found); });
  }
  found->touched = ++prepared.now;
  return found;
}

}  // namespace PHN_RUNTIME
