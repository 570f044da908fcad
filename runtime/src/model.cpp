// Positions of mesh nodes in a model.
#include "model.hpp"

#include "lookup.hpp"

namespace PHN_RUNTIME {

std::int32_t find_vertex(const phn_model& model, std::int32_t node) {
  const std::int32_t output = find_sorted(model.output_nodes, model.n_output, node);
  if (output >= 0) return output;
  const std::int32_t fixed = find_sorted(model.fixed_nodes, model.n_fixed, node);
  return fixed < 0 ? -1 : model.n_output + fixed;
}

std::int32_t find_active(const phn_model& model, std::int32_t node) {
  return find_sorted(model.active_nodes, model.n_active, node);
}

}  // namespace PHN_RUNTIME
