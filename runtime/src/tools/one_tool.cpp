// The C interface of phynness.h for one tool: at a node its response alone, between nodes their mean or their coupling.
#include <phynness/phynness.h>

#include "core/bound.hpp"
#include "core/families.hpp"
#include "tools/coupled.hpp"
#include "tools/nearest.hpp"

using namespace PHN_RUNTIME;

namespace {

/// Where a tool is, and a copy of its displacement, because an output may overlap the tool.
struct ToolQuery {
  std::int32_t active;  ///< position of the tool's node among the active nodes; -1: the tool is at `place`
  double d[3];
  Place place;
};

/// Checks a tool. @return a status of phynness.h
int find_tool(const phn_model* model, const phn_tool* tool, ToolQuery& query) {
  if (model == nullptr || tool == nullptr) return PHN_ERROR_ARGUMENT;
  for (int k = 0; k < 3; ++k) query.d[k] = tool->displacement[k];
  if (tool->weights[0] == 1 && tool->weights[1] == 0 && tool->weights[2] == 0) {
    query.active = find_active(*model, tool->nodes[0]);
    if (query.active >= 0) {
      if (!is_of_this_version(*tool)) return PHN_ERROR_VERSION;
      return finite(query.d) ? PHN_OK : PHN_ERROR_NOT_FINITE;
    }
  }
  const int refused = find_place(*model, *tool, query.place);
  if (refused != PHN_OK) return refused;
  query.active = query.place.n_nodes == 1 && query.place.weight[0] == 1 ? query.place.active[0] : -1;
  return PHN_OK;
}
int find_tool(const phn_model* model, const phn_data* data, const phn_tool* tool, ToolQuery& query) {
  if (model == nullptr || data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  return find_tool(model, tool, query);
}

/// Checks the outputs for force, energy and stiffness. @return a status of phynness.h
int check_derivatives(const phn_model& model, const double* force, const double* energy, const double* stiffness) {
  constexpr std::size_t vector_bytes = 3 * sizeof(double), matrix_bytes = 9 * sizeof(double);
  if (overlap(force, vector_bytes, energy, sizeof *energy) || overlap(force, vector_bytes, stiffness, matrix_bytes) ||
      overlap(energy, sizeof *energy, stiffness, matrix_bytes))
    return PHN_ERROR_OVERLAP;
  return model.has_energy ? PHN_OK : PHN_ERROR_UNDEFINED;
}

/// Computes force, energy and stiffness of a round tool between nodes. @return warnings
int mean_response(const phn_model& model, const phn_data& data, const ToolQuery& query, double* force, double* energy,
                  double* stiffness) {
  Vector d, f = {};
  Matrix k = {};
  clamp(query.d, 1, largest_between_nodes(model), d.x);
  const Mean mean = mean_at(model, data.coupling->neighbours, query.place);
  respond_as_mean(*data.level, mean, d, f, energy, stiffness != nullptr ? &k : nullptr);
  for (int i = 0; i < 3 && force != nullptr; ++i) force[i] = f[i];
  for (int i = 0; i < 9 && stiffness != nullptr; ++i) stiffness[i] = k.a[i];
  int status = is_beside_fixed(model, query.place) ? PHN_WARNING_OUTSIDE : PHN_OK;
  for (std::int32_t i = 0; i < query.place.n_nodes; ++i)
    if (query.place.counts(i))
      status |= warnings(model, model.active[query.place.active[i]], (d / mean.transmission).x);
  return status;
}

/// Computes force and energy of node probes between nodes. @return a status of phynness.h
int coupled_response(const phn_model& model, phn_data& data, const phn_tool& tool, double* force, double* energy) {
  phn_coupled coupled;
  const int status = couple_tools(model, data, 1, &tool, coupled);
  if (status < 0) return status;
  for (int k = 0; k < 3 && force != nullptr; ++k) force[k] = data.coupling->point[0].force[k];
  if (energy != nullptr) *energy = coupled.energy;
  return status;
}

/// Sets the bound between nodes (formats/model.md, Bounds), a function of the largest bound of the nodes, of the
/// deviation of their forces from the mean, and of this mean. It is not below the mean bound of the nodes, because the
/// deviation vanishes at a node. @return a status of phynness.h
int bound_between(const phn_model& model, const ToolQuery& query, double& bound) {
  const Place& place = query.place;
  if (model.bound_between == nullptr) return PHN_ERROR_UNDEFINED;
  const double transmission = place.n_nodes == 1 ? transmission_of(model, place) : 1;
  Vector d, force[most_corners], mean = {};
  clamp(query.d, transmission, PHN_NO_BOUND, d.x);
  int status = is_beside_fixed(model, place) ? PHN_WARNING_OUTSIDE : PHN_OK;
  double sum = 0, largest = 0, least = 0, spread = 0;
  for (std::int32_t i = 0; i < place.n_nodes; ++i) sum += place.weight[i];
  for (std::int32_t i = 0; i < place.n_nodes; ++i) {
    const ActiveNode& node = model.active[place.active[i]];
    if (place.counts(i)) {
      const int warned = warnings(model, node, d.x);
      const double of_node = (warned & PHN_WARNING_OUTSIDE) != 0 ? PHN_NO_BOUND : error_bound(model, node, d.x);
      status |= warned;
      largest = std::fmin(PHN_NO_BOUND, std::fmax(largest, of_node / transmission));
      least += place.weight[i] / sum * of_node;
    }
    evaluate_force(model, node, d.x, force[i].x);
    force[i] /= transmission;
    mean += (place.weight[i] / sum) * force[i];
  }
  for (std::int32_t i = 0; i < place.n_nodes; ++i) spread += place.weight[i] / sum * length((force[i] - mean).x);
  const double x[] = {largest + spread, spread, length(mean.x)};
  bound = (status & PHN_WARNING_OUTSIDE) != 0 ? PHN_NO_BOUND
          : place.n_nodes == 1                ? largest
                                              : std::fmax(least, coupled_bound(model.bound_between, x, PHN_NO_BOUND));
  return status;
}

/// Sets the smallest trained depth of the nodes of a round tool between nodes. @return a status of phynness.h
int depth_between(const phn_model& model, const ToolQuery& query, double& depth) {
  const Place& place = query.place;
  if (!needs_no_coupling(model, place)) return PHN_ERROR_UNDEFINED;
  Vector d;
  clamp(query.d, transmission_of(model, place), PHN_NO_BOUND, d.x);
  int status = PHN_OK;
  depth = PHN_NO_BOUND;
  for (std::int32_t i = 0; i < place.n_nodes; ++i) {
    if (!place.counts(i)) continue;
    const ActiveNode& node = model.active[place.active[i]];
    depth = std::fmin(depth, trained_depth(model, node, d.x));
    if (outside(model, node, d.x)) status = PHN_WARNING_OUTSIDE;
  }
  if (!is_beside_fixed(model, place)) return status;
  depth = 0;
  return PHN_WARNING_OUTSIDE;
}

VertexKind kind_of(const phn_model& model, std::int32_t vertex) {
  if (vertex >= model.n_output) return VertexKind::fixed;
  Corner corner[3];
  const std::int32_t n = find_corners(model, vertex_node(model, vertex), corner);
  if (n == 0) return VertexKind::untouchable;
  for (std::int32_t i = 0; i < n; ++i) {
    const ActiveNode& node = model.active[corner[i].active];
    // Node probes that cannot be coupled answer at the node only.
    if (!node.moves_mean && (node.output < 0 || !has_deformation(model, node)))
      return n == 1 ? VertexKind::node_only : VertexKind::untouchable;
  }
  return VertexKind::movable;
}

}  // namespace

extern "C" {

int phn_nearest(const phn_model* model, const double x[3], phn_tool* tool, double point[3], double* distance) {
  return answer_nearest(
      model != nullptr, x, tool, point, distance,
      [&](const double* from) {
        return nearest_place(
            model->triangles, model->n_triangles, from, [&](std::int32_t v) { return vertex_point(*model, v); },
            [&](std::int32_t v) { return kind_of(*model, v); });
      },
      [&](std::int32_t v) { return vertex_node(*model, v); });
}

int phn_force(const phn_model* model, phn_data* data, const phn_tool* tool, double force[3], double* energy,
              double stiffness[9]) {
  ToolQuery query;
  int status = find_tool(model, data, tool, query);
  const bool derivatives = energy != nullptr || stiffness != nullptr;
  if (force == nullptr && !derivatives) status = PHN_ERROR_ARGUMENT;
  if (status == PHN_OK && derivatives) status = check_derivatives(*model, force, energy, stiffness);
  if (status == PHN_OK && query.active >= 0) {
    double unused[3];
    const ActiveNode& node = data->level->active[query.active];
    evaluate_force(*data->level, node, query.d, force != nullptr ? force : unused, energy, stiffness);
    return warnings(*model, node, query.d);
  }
  if (status == PHN_OK) {
    if (needs_no_coupling(*model, query.place)) return mean_response(*model, *data, query, force, energy, stiffness);
    status = stiffness != nullptr ? PHN_ERROR_UNDEFINED : coupled_response(*model, *data, *tool, force, energy);
    if (status >= 0) return status;
  }
  zero(force, 3);
  zero(energy, 1);
  return refuse(status, stiffness, 9);
}

int phn_deform(const phn_model* model, phn_data* data, const phn_tool* tool, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  ToolQuery query;
  int status = find_tool(model, data, tool, query);
  if (status == PHN_OK && query.active >= 0) {
    const ActiveNode& node = data->level->active[query.active];
    if (has_deformation(*model, node)) {
      evaluate_deformation(*data->level, *data, query.active, query.d, out);
      return warnings(*model, node, query.d);
    }
    status = PHN_ERROR_UNDEFINED;
  }
  phn_coupled coupled;
  if (status == PHN_OK) status = couple_tools(*model, *data, 1, tool, coupled);
  zero(out, 3 * model->n_output);
  return status < 0 ? status : field_of_tools(*model, *data, out);
}

int phn_field(const phn_model* model, phn_data* data, const phn_tool* tool, int32_t field, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  const std::int32_t n = model->n_output;
  if (field < 0 || field >= model->n_fields) return refuse(PHN_ERROR_ARGUMENT, out, n);
  ToolQuery query;
  const int refused = find_tool(model, data, tool, query);
  if (refused != PHN_OK) return refuse(refused, out, n);
  if (query.active >= 0) {
    query.place.n_nodes = 1;
    query.place.active[0] = query.active;
    query.place.fixed_weight = 0;
  } else if (!is_round(*model, query.place)) {
    return refuse(PHN_ERROR_UNDEFINED, out, n);
  }
  int status = is_beside_fixed(*model, query.place) ? PHN_WARNING_OUTSIDE : PHN_OK;
  double sum = 0;
  for (std::int32_t i = 0; i < query.place.n_nodes; ++i) {
    const ActiveNode& node = data->level->active[query.place.active[i]];
    if (node.rest != nullptr || node.modal->fields[field].n_modes == 0) return refuse(PHN_ERROR_UNDEFINED, out, n);
    sum += query.place.weight[i];
    if (query.active >= 0 || query.place.counts(i)) status |= warnings(*model, node, query.d);
  }
  if (query.active >= 0) {
    modal_field(*data->level, *data->level->active[query.active].modal, field, query.d, data->scratch, out);
    return status;
  }
  zero(out, n);
  for (std::int32_t i = 0; i < query.place.n_nodes; ++i) {
    const ActiveNode& node = data->level->active[query.place.active[i]];
    modal_field(*data->level, *node.modal, field, query.d, data->scratch, data->field);
    for (std::int32_t j = 0; j < n; ++j) out[j] += query.place.weight[i] / sum * data->field[j];
  }
  return status;
}

int phn_prepare(const phn_model* model, phn_data* data, const phn_tool* tool) {
  ToolQuery query;
  const int refused = find_tool(model, data, tool, query);
  if (refused != PHN_OK) return refused;
  if (query.active >= 0) {
    prepare(*model, data->prepared, query.active);
    return PHN_OK;
  }
  for (std::int32_t i = 0; i < query.place.n_nodes; ++i) prepare(*model, data->prepared, query.place.active[i]);
  return PHN_OK;
}

int phn_depth(const phn_model* model, const phn_tool* tool, double* depth) {
  if (depth == nullptr) return PHN_ERROR_ARGUMENT;
  double found = 0;
  ToolQuery query;
  int status = find_tool(model, tool, query);
  if (status == PHN_OK && query.active >= 0) {
    const ActiveNode& node = model->active[query.active];
    found = trained_depth(*model, node, query.d);
    status = outside(*model, node, query.d) ? PHN_WARNING_OUTSIDE : PHN_OK;
  } else if (status == PHN_OK) {
    status = depth_between(*model, query, found);
  }
  *depth = found;
  return status;
}

int phn_bound(const phn_model* model, const phn_tool* tool, double* bound) {
  if (bound == nullptr) return PHN_ERROR_ARGUMENT;
  double found = PHN_NO_BOUND;
  ToolQuery query;
  int status = find_tool(model, tool, query);
  if (status == PHN_OK && query.active >= 0) {
    const ActiveNode& node = model->active[query.active];
    status = model->bound_between == nullptr ? PHN_ERROR_UNDEFINED : warnings(*model, node, query.d);
    if (status >= 0 && (status & PHN_WARNING_OUTSIDE) == 0) found = error_bound(*model, node, query.d);
  } else if (status == PHN_OK) {
    status = bound_between(*model, query, found);
  }
  *bound = found;
  return status;
}

}  // extern "C"
