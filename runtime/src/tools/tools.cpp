// The C interface of phynness_tools.h.
#include <phynness/phynness_tools.h>

#include "tools/coupled.hpp"
#include "tools/triangle.hpp"

using namespace PHN_RUNTIME;

namespace {

/// Tolerance of the sum of barycentric weights; a point whose movable part is smaller counts as fixed.
constexpr double weight_slack = 1e-6;

/// Components of the argument of phn_nearest are clamped to this [m].
constexpr double largest_place = 1e60;

phn_data* make_tools(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  phn_data* data = make_data(arena, model, max_tools);
  auto* made = arena.take<Coupling>(1);
  const Coupling coupling = lay_out_coupling(arena, model, max_tools);
  if (data == nullptr || arena.overflow()) return nullptr;
  *made = coupling;
  data->coupling = made;
  return data;
}

/// Checks one tool and finds its nodes.
int find_point(const phn_model& model, const phn_tool& tool, HeldPoint& point) {
  point.n_nodes = 0;
  double sum = 0, movable = 0;
  for (int k = 0; k < 3; ++k) {
    const double w = tool.weights[k];
    if (!(w >= 0 && w <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
    sum += w;
    if (w == 0) continue;
    const std::int32_t active = find_active(model, tool.nodes[k]);
    if (active < 0 && find_vertex(model, tool.nodes[k]) < model.n_output) return PHN_ERROR_NOT_ACTIVE;
    if (active < 0) continue;  // fixed
    movable += w;
    std::int32_t i = 0;
    while (i < point.n_nodes && point.active[i] != active) ++i;
    if (i == point.n_nodes) point.weight[point.n_nodes++] = 0;
    point.active[i] = active;
    point.weight[i] += w;
  }
  if (!(sum >= 1 - weight_slack && sum <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
  if (!(movable > weight_slack)) return PHN_ERROR_NOT_ACTIVE;
  return finite(tool.displacement) ? PHN_OK : PHN_ERROR_NOT_FINITE;
}

bool same_node(const HeldPoint& a, const HeldPoint& b) {
  return a.n_nodes == 1 && b.n_nodes == 1 && a.active[0] == b.active[0];
}

/// One tool at one node: the response of that node, without a system to solve.
CoupledResult single(const phn_model& model, Coupling& c, const Vector& target) {
  HeldPoint& point = c.point[0];
  const ActiveNode& node = model.active[point.active[0]];
  c.n_sets = 1;
  c.field_turn[0] = {};
  point.own = target;
  point.reach[0] = diagonal(1 / point.weight[0]);
  const Vector d = target / point.weight[0];
  c.field[0] = {1, d};
  double energy = 0;
  evaluate_derivatives(model, node, d.x, point.force.x, has_energy(model) ? &energy : nullptr, nullptr);
  point.force /= point.weight[0];
  if (has_deformation(model, node)) basis_of(model, node, d.x, c.field_basis, c.kernel);
  return {true, 0, energy};
}

/// Warnings of all nodes at the displacements at which their responses are evaluated.
int warnings_of(const phn_model& model, const Coupling& c) {
  int status = PHN_OK;
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    const HeldPoint& point = c.point[t];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      status |= warnings(model, model.active[point.active[i]], (point.reach[i] * point.own).x);
    }
  }
  return status;
}

/// @param x  finite. @return a status of phynness.h
int find_nearest(const phn_model& model, const double* x, phn_tool& tool, double* point) {
  double from[3];
  cut(x, 1, largest_place, from);
  double least = -1;
  for (std::int32_t t = 0; t < model.n_triangles; ++t) {
    const std::int32_t* vertex = model.triangles + 3 * static_cast<std::size_t>(t);
    const double* corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = vertex_point(model, vertex[k]);
    double weight[3], nearest[3], distance = 0;
    nearest_on_triangle(corner, from, weight, nearest, distance);
    if (!(least < 0 || distance < least)) continue;
    least = distance;
    for (int k = 0; k < 3; ++k) {
      tool.nodes[k] = vertex_node(model, vertex[k]);
      tool.weights[k] = weight[k];
      point[k] = nearest[k];
    }
  }
  return least < 0 ? PHN_ERROR_UNDEFINED : PHN_OK;
}

/// The forces remain in the data; the caller copies them to the output. @return a status of phynness.h
int couple(const phn_model* model, phn_data* data, std::int32_t n_tools, const phn_tool* tools, const double* forces,
           const phn_coupled* place, phn_coupled& result) {
  if (n_tools < 0 || model == nullptr || data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  if (n_tools > 0 && (tools == nullptr || forces == nullptr)) return PHN_ERROR_ARGUMENT;
  if (overlap(forces, 3 * sizeof *forces * static_cast<std::size_t>(n_tools), place, sizeof *place))
    return PHN_ERROR_OVERLAP;
  if (n_tools > most_coupled) return PHN_ERROR_TOO_MANY_TOOLS;
  if (n_tools > most_tools(*data)) return PHN_ERROR_TOOLS;
  if (data->coupling == nullptr) return PHN_OK;
  Coupling& c = *data->coupling;
  c.n_tools = 0;
  const double largest =
      phynness::schema::traits(model->family).proportional ? largest_linear : largest_coupled * model->max_displacement;
  Vector targets[most_coupled];
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int refused = find_point(*model, tools[t], c.point[t]);
    if (refused != PHN_OK) return refused;
    cut(tools[t].displacement, 1, largest, targets[t].x);
    for (std::int32_t s = 0; s < t; ++s) {
      if (same_node(c.point[s], c.point[t])) return PHN_ERROR_SAME_NODE;
    }
  }
  c.model = data->level;
  const bool alone = n_tools == 1 && c.point[0].n_nodes == 1;
  for (std::int32_t t = 0; t < n_tools && !alone; ++t) {
    for (std::int32_t i = 0; i < c.point[t].n_nodes; ++i) {
      const ActiveNode& node = c.model->active[c.point[t].active[i]];
      if (node.output < 0 || !has_deformation(*c.model, node)) return PHN_ERROR_UNDEFINED;
    }
  }
  if (n_tools == 0) return PHN_OK;
  c.n_tools = n_tools;
  const auto solved = alone ? single(*c.model, c, targets[0]) : solve_coupled(*c.model, c, targets);
  const int status = (solved.settled ? PHN_OK : PHN_WARNING_UNSETTLED) | warnings_of(*model, c);
  result = {solved.residual, std::isfinite(solved.energy) ? solved.energy : 0};
  return status;
}

}  // namespace

extern "C" {

int phn_tools_size(const phn_model* model, int32_t max_tools, size_t* bytes) {
  return data_size(make_tools, model, max_tools, bytes);
}

int phn_tools_init(void* memory, size_t bytes, const phn_model* model, int32_t max_tools, phn_data** data) {
  return data_init(make_tools, memory, bytes, model, max_tools, data);
}

int phn_nearest(const phn_model* model, const double x[3], phn_tool* tool, double point[3]) {
  phn_tool found = {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
  double place[3] = {0, 0, 0};
  int status = PHN_ERROR_ARGUMENT;
  if (model != nullptr && x != nullptr && tool != nullptr) {
    status = overlap(tool, sizeof *tool, point, sizeof place) ? PHN_ERROR_OVERLAP
             : finite(x)                                      ? find_nearest(*model, x, found, place)
                                                              : PHN_ERROR_NOT_FINITE;
  }
  if (tool != nullptr) *tool = found;
  for (int k = 0; k < 3 && point != nullptr; ++k) point[k] = place[k];
  return status;
}

int phn_couple(const phn_model* model, phn_data* data, int32_t n_tools, const phn_tool* tools, double* forces,
               phn_coupled* result) {
  phn_coupled coupled = {0, 0};
  const int status = couple(model, data, n_tools, tools, forces, result, coupled);
  // The tools have been read; the forces may overlap them.
  for (std::int32_t t = 0; forces != nullptr && t < n_tools; ++t) {
    for (int k = 0; k < 3; ++k) *forces++ = status < 0 ? 0 : data->coupling->point[t].force[k];
  }
  if (result != nullptr) *result = coupled;
  return status;
}

int phn_coupled_deform(const phn_model* model, phn_data* data, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  zero(out, 3 * model->n_output);
  if (data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  if (data->coupling == nullptr) return PHN_OK;
  const Coupling& c = *data->coupling;
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    for (std::int32_t i = 0; i < c.point[t].n_nodes; ++i) {
      if (!has_deformation(*model, model->active[c.point[t].active[i]])) return PHN_ERROR_UNDEFINED;
    }
  }
  coupled_field(*c.model, c, data->prepared, data->scratch, data->field, out);
  return warnings_of(*model, c);
}

}  // extern "C"
