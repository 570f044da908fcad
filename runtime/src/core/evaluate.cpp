#include "core/evaluate.hpp"

#include <cmath>

#include "core/families.hpp"
#include "core/kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// Number of output nodes, rounded up to whole blocks.
std::size_t node_count(const phn_model& model) {
  constexpr std::size_t nodes = nodes_per_block;
  return (static_cast<std::size_t>(model.n_output) + nodes - 1) / nodes * nodes;
}

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  PreparedNodes prepared = {0, 0, nullptr};
  if (model.prepared_neurons == 0 && model.prepared_modes == 0) return prepared;
  prepared.n = 3 * (max_tools < PHN_MOST_COUPLED ? max_tools : PHN_MOST_COUPLED);
  prepared.node = arena.take<PreparedNode>(static_cast<std::size_t>(prepared.n));
  const auto m = static_cast<std::size_t>(model.prepared_modes);
  for (std::int32_t i = 0; i < prepared.n; ++i) {
    PreparedNode entry = {-1, 0, nullptr, nullptr, nullptr};
    if (model.prepared_neurons > 0) entry.gaussians = arena.take<double>(node_count(model), model.prepared_neurons);
    if (model.prepared_modes > 0) {
      entry.near_mode = arena.take<double>(model.prepared_near);
      entry.modes = arena.take<float>(prepared_rows(model), m);
    }
    if (prepared.node) prepared.node[i] = entry;
  }
  return prepared;
}

}  // namespace

phn_data* make_data(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  phn_data data = {};
  auto* made = arena.take<phn_data>(1);
  data.model = data.level = &model;
  data.max_tools = max_tools;
  data.scratch = arena.take<double>(model.n_scratch);
  data.field = arena.take<double>(3, static_cast<std::size_t>(model.n_output));
  data.prepared = lay_out_prepared(arena, model, max_tools);
  data.coupling = make_coupling(arena, model, max_tools);
  if (made != nullptr && !arena.overflow()) *made = data;
  return made;
}

std::int32_t find_vertex(const phn_model& model, std::int32_t node) {
  const std::int32_t output = find_sorted(model.output_nodes, model.n_output, node);
  if (output >= 0) return output;
  const std::int32_t fixed = find_sorted(model.fixed_nodes, model.n_fixed, node);
  return fixed < 0 ? -1 : model.n_output + fixed;
}

std::int32_t find_active(const phn_model& model, std::int32_t node) {
  return find_sorted(model.active_nodes, model.n_active, node);
}

double length(const double* d) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::fmax(largest, std::fabs(d[k]));
  if (largest > 1e-140 && largest < 1e140) return std::sqrt(dot(d, d));
  if (!(largest > 0) || std::isinf(largest)) return largest;
  // Scaling by a power of two is exact and keeps the squares in range.
  int exponent = 0;
  std::frexp(largest, &exponent);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double t = std::ldexp(d[k], -exponent);
    sum += t * t;
  }
  return std::ldexp(std::sqrt(sum), exponent);
}

void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force, double* energy,
                    double* stiffness) {
  with_response(model, node,
                [&](const auto& response) { response_derivatives(response, d, force, energy, stiffness); });
}

bool has_deformation(const phn_model& model, const ActiveNode& node) {
  return with_response(model, node, [](const auto& response) { return has_deformation(response); });
}

std::int32_t basis_size(const phn_model& model, const ActiveNode& node) {
  return with_response(model, node, [](const auto& response) { return basis_size(response); });
}

void basis_of(const phn_model& model, const ActiveNode& node, const double* d, double* basis, double* scratch) {
  with_response(model, node, [&](const auto& response) { response_basis(model, response, d, basis, scratch); });
}

void field_of_basis(const phn_model& model, const ActiveNode& node, const PreparedNode* prepared, double share,
                    const double* d, const double* basis, double* scratch, double* field) {
  with_response(model, node,
                [&](const auto& response) { response_field(model, response, prepared, share, basis, scratch, field); });
  for (std::int32_t p = 0; p < node.n_prescribed && !node.moves_mean; ++p)
    for (int k = 0; k < 3; ++k) field[3 * node.prescribed[p] + k] = node.prescribed_weight[p] * d[k];
}

std::size_t prepared_rows(const phn_model& model) {
  constexpr std::size_t rows = rows_per_block;
  return (static_cast<std::size_t>(model.shared.n_rows) + rows - 1) / rows * rows;
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

void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d, double* field) {
  const ActiveNode& node = model.active[active];
  double* basis = data.scratch + model.n_scratch - model.n_basis;
  basis_of(model, node, d, basis, data.scratch);
  field_of_basis(model, node, prepare(model, data.prepared, active), 1, d, basis, data.scratch, field);
}

bool outside(const phn_model& model, const ActiveNode& node, const double* d) {
  if (schema::traits(model.kind).proportional) return length(d) > largest_linear;
  if (node.rest != nullptr) return true;
  // Most displacements need no square root. Squares that overflow or underflow are handled below.
  if (dot(d, d) < node.least_depth * node.least_depth) return false;
  const double size = length(d), slack = depth_slack<double>;
  return size > slack * node.least_depth && size > slack * trained_depth(model, node, d);
}

int warnings(const phn_model& model, const ActiveNode& node, const double* d) {
  return (outside(model, node, d) ? PHN_WARNING_OUTSIDE : 0) | (node.incomplete ? PHN_WARNING_INCOMPLETE : 0);
}

double trained_depth(const phn_model& model, const ActiveNode& node, const double* d) {
  if (node.rest != nullptr) return 0;
  const double size = length(d);
  // Products of such numbers could be subnormal or infinite.
  const bool extreme = size > 0 && (size < 1e-290 || size > 1e290);
  const double e[3] = {extreme ? d[0] / size : d[0], extreme ? d[1] / size : d[1], extreme ? d[2] / size : d[2]};
  return depth_along(model.directions, node.trained_depth, model.n_directions, e, extreme ? 1 : size,
                     model.max_displacement_m);
}

}  // namespace PHN_RUNTIME
