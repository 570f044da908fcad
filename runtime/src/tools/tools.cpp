// The C interface of phynness_tools.h.
#include <phynness/phynness_tools.h>

#include "core/bound.hpp"
#include "tools/coupled.hpp"
#include "tools/triangle.hpp"

using namespace PHN_RUNTIME;

namespace {

/// Components of the argument of phn_nearest are clamped to this [m].
constexpr double largest_place = 1e60;

bool same_node(const Place& a, const Place& b) {
  return a.n_nodes == 1 && b.n_nodes == 1 && a.active[0] == b.active[0];
}

/// Components of displacements are clamped to this [m].
double largest_displacement(const phn_model& model) {
  return phynness::schema::traits(model.kind).proportional ? largest_linear
                                                           : largest_coupled * model.max_displacement_m;
}

/// The warnings of a node of a tool at a displacement [m].
int warned_at(const phn_model& model, std::int32_t active, const Vector& d) {
  return warnings(model, model.active[active], d.x);
}

/// One tool at one node: the response of that node. One round tool: the mean of the responses around it. Nothing has
/// to be solved.
CoupledResult answer_alone(const phn_model& model, Coupling& c, const Vector& target) {
  Constraint& point = c.point[0];
  const Mean mean = mean_at(model, c.neighbours, point);
  c.n_sets = 1;
  c.field_turn[0] = {};
  point.own = target;
  double energy = 0;
  respond_alone(model, mean, target, point.force, model.has_energy ? &energy : nullptr, nullptr);
  const Vector d = target / mean.lever;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& node = model.active[point.active[i]];
    c.field[i] = {mean.share[i], d};
    c.warned |= warned_at(*model.full, point.active[i], diagonal(1 / mean.lever) * target);
    if (!has_deformation(model, node)) continue;
    double* basis = c.field_basis + static_cast<std::size_t>(i) * model.n_basis;
    basis_of(model, node, d.x, basis, c.kernel);
    for (std::int32_t j = 0; j < basis_size(model, node); ++j) basis[j] *= mean.share[i];
  }
  if (is_beside_fixed(model, point)) c.warned |= PHN_WARNING_OUTSIDE;
  return {true, 0, energy};
}

CoupledResult answer_coupled(const phn_model& model, Coupling& c, const Vector* targets) {
  const CoupledResult solved = solve_coupled(model, c, targets);
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    const Constraint& point = c.point[t];
    for (std::int32_t i = 0; i < point.n_nodes; ++i)
      c.warned |= warned_at(*model.full, point.active[i], point.reach[i] * point.own);
  }
  return solved;
}

/// Whether the points of node probes can be coupled: each of their nodes has an output and a deformation.
bool can_couple(const phn_model& model, const Coupling& c, std::int32_t n_tools) {
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const Constraint& point = c.point[t];
    if (point.n_nodes > most_nodes) return false;
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const ActiveNode& node = model.active[point.active[i]];
      if (node.output < 0 || !has_deformation(model, node)) return false;
    }
  }
  return true;
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

/// @return a status of phynness.h
int find_alone(const phn_model* model, const phn_tool* tool, Place& place) {
  if (model == nullptr || tool == nullptr) return PHN_ERROR_ARGUMENT;
  const int refused = find_place(*model, *tool, place);
  return refused == PHN_OK && !answers_alone(*model, place) ? PHN_ERROR_UNDEFINED : refused;
}

/// Force, energy and stiffness of one tool, of which any may be null but not all. @return a status of phynness.h
int force_at(const phn_model* model, const phn_data* data, const phn_tool* tool, Vector& force, double* energy,
             Matrix* stiffness) {
  if (model == nullptr || data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  if ((energy || stiffness) && !model->has_energy) return PHN_ERROR_UNDEFINED;
  Place place;
  const int refused = find_alone(model, tool, place);
  if (refused != PHN_OK) return refused;
  Vector d;
  cut(tool->displacement, 1, largest_displacement(*model), d.x);
  const Mean mean = mean_at(*model, data->coupling->neighbours, place);
  respond_alone(*data->level, mean, d, force, energy, stiffness);
  int status = is_beside_fixed(*model, place) ? PHN_WARNING_OUTSIDE : PHN_OK;
  for (std::int32_t i = 0; i < place.n_nodes; ++i)
    status |= warnings(*model, model->active[place.active[i]], (d / mean.lever).x);
  return status;
}

/// The bound of one tool (formats/model.md, Bounds): the largest bound of its nodes; between nodes a function of it, of
/// how far their forces differ from their mean, and of this mean. @return a status of phynness.h
int bound_at(const phn_model& model, const Place& place, const double* displacement, double& bound) {
  const double lever = place.n_nodes == 1 ? lever_of(model, place) : 1;
  Vector d, force[most_corners], mean = {};
  cut(displacement, lever, PHN_NO_BOUND, d.x);
  int status = is_beside_fixed(model, place) ? PHN_WARNING_OUTSIDE : PHN_OK;
  double sum = 0, largest = 0, spread = 0;
  for (std::int32_t i = 0; i < place.n_nodes; ++i) sum += place.weight[i];
  for (std::int32_t i = 0; i < place.n_nodes; ++i) {
    double of_node = 0;
    const int said = phn_bound(&model, model.active_nodes[place.active[i]], d.x, &of_node);
    if (said < 0) return said;
    status |= said;
    largest = std::fmin(PHN_NO_BOUND, std::fmax(largest, of_node / lever));
    evaluate_force(model, model.active[place.active[i]], d.x, force[i].x);
    force[i] /= lever;
    mean += (place.weight[i] / sum) * force[i];
  }
  for (std::int32_t i = 0; i < place.n_nodes; ++i) spread += place.weight[i] / sum * length((force[i] - mean).x);
  const double x[] = {largest + spread, spread, length(mean.x)};
  bound = (status & PHN_WARNING_OUTSIDE) != 0 ? PHN_NO_BOUND
          : place.n_nodes == 1                ? largest
                                              : coupled_bound(model.bound_between, x, PHN_NO_BOUND);
  return status;
}

/// The forces remain in the data; the caller copies them to the output. @return a status of phynness.h
int couple(const phn_model* model, phn_data* data, std::int32_t n_tools, const phn_tool* tools, const double* forces,
           const phn_coupled* place, phn_coupled& result) {
  if (n_tools < 0 || model == nullptr || data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  if (n_tools > 0 && (tools == nullptr || forces == nullptr)) return PHN_ERROR_ARGUMENT;
  if (overlap(forces, 3 * sizeof *forces * static_cast<std::size_t>(n_tools), place, sizeof *place))
    return PHN_ERROR_OVERLAP;
  if (n_tools > most_coupled) return PHN_ERROR_TOO_MANY_TOOLS;
  if (n_tools > data->max_tools) return PHN_ERROR_TOOLS;
  Coupling& c = *data->coupling;
  c.n_tools = 0;
  c.warned = PHN_OK;
  if (n_tools > 1 && has_round_tools(c)) return PHN_ERROR_ROUND_TOOLS;
  const double largest = largest_displacement(*model);
  Vector targets[most_coupled];
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int refused = find_place(*model, tools[t], c.point[t]);
    if (refused != PHN_OK) return refused;
    cut(tools[t].displacement, 1, largest, targets[t].x);
    for (std::int32_t s = 0; s < t; ++s) {
      if (same_node(c.point[s], c.point[t])) return PHN_ERROR_SAME_NODE;
    }
  }
  c.model = data->level;
  if (n_tools == 0) return PHN_OK;
  const bool alone = n_tools == 1 && answers_alone(*model, c.point[0]);
  if (!alone && (has_round_tools(c) || !can_couple(*c.model, c, n_tools))) return PHN_ERROR_UNDEFINED;
  c.n_tools = n_tools;
  const CoupledResult solved = alone ? answer_alone(*c.model, c, targets[0]) : answer_coupled(*c.model, c, targets);
  result = {solved.residual, std::isfinite(solved.energy) ? solved.energy : 0};
  return solved.settled ? c.warned : c.warned | PHN_WARNING_UNSETTLED;
}

}  // namespace

extern "C" {

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

int phn_force_at(const phn_model* model, phn_data* data, const phn_tool* tool, double force[3], double* energy,
                 double stiffness[9]) {
  constexpr std::size_t one = sizeof(double);
  Vector f = {};
  double e = 0;
  Matrix k = {};
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(force, 3 * one, energy, one) || overlap(force, 3 * one, stiffness, 9 * one) ||
      overlap(energy, one, stiffness, 9 * one)) {
    status = PHN_ERROR_OVERLAP;
  } else if (force != nullptr || energy != nullptr || stiffness != nullptr) {
    status = force_at(model, data, tool, f, energy ? &e : nullptr, stiffness ? &k : nullptr);
  }
  // The tool has been read; the outputs may overlap it.
  for (int i = 0; i < 3 && force != nullptr; ++i) force[i] = f[i];
  if (energy != nullptr) *energy = e;
  for (int i = 0; i < 9 && stiffness != nullptr; ++i) stiffness[i] = k.a[i];
  return status;
}

int phn_trained_depth_at(const phn_model* model, const phn_tool* tool, double* depth) {
  if (depth == nullptr) return PHN_ERROR_ARGUMENT;
  double found = 0;
  Place place;
  int status = find_alone(model, tool, place);
  Vector d;
  if (status >= 0) cut(tool->displacement, lever_of(*model, place), PHN_NO_BOUND, d.x);
  for (std::int32_t i = 0; status >= 0 && i < place.n_nodes; ++i) {
    double one;
    const int said = phn_trained_depth(model, model->active_nodes[place.active[i]], d.x, &one);
    status = said < 0 ? said : status | said;
    found = i == 0 ? one : std::fmin(found, one);
  }
  if (status >= 0 && is_beside_fixed(*model, place)) {
    found = 0;
    status |= PHN_WARNING_OUTSIDE;
  }
  *depth = status < 0 ? 0 : found;
  return status;
}

int phn_bound_at(const phn_model* model, const phn_tool* tool, double* bound) {
  if (bound == nullptr) return PHN_ERROR_ARGUMENT;
  double found = 0;
  Place place;
  int status = model == nullptr || tool == nullptr ? PHN_ERROR_ARGUMENT : find_place(*model, *tool, place);
  if (status == PHN_OK) status = bound_at(*model, place, tool->displacement, found);
  *bound = found;  // the tool has been read
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
  const Coupling& c = *data->coupling;
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    for (std::int32_t i = 0; i < c.point[t].n_nodes; ++i) {
      if (!has_deformation(*model, model->active[c.point[t].active[i]])) return PHN_ERROR_UNDEFINED;
    }
  }
  coupled_field(*c.model, c, data->prepared, data->scratch, data->field, out);
  return c.warned;
}

}  // extern "C"
