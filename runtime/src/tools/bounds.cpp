// Bounds of the force's error of tools between nodes and of several tools (formats/model.md, Bounds).
#include <phynness/phynness_tools.h>

#include <cmath>

#include "core/bound.hpp"
#include "core/evaluate.hpp"
#include "tools/coupled.hpp"

using namespace PHN_RUNTIME;

namespace {

/// One tool alone: the largest bound of its nodes, and how far their forces differ from their mean.
struct Alone {
  double bound = 0, spread = 0;
  Vector force = {};
};
/// @return the sum of the warnings, or an error
int alone_at(const phn_model& model, const Place& place, const Vector& d, Alone& alone) {
  const double lever = place.n_nodes == 1 ? lever_of(model, place) : 1;
  const Vector at = d / lever;
  Vector force[most_corners];
  int status = is_beside_fixed(model, place) ? PHN_WARNING_OUTSIDE : PHN_OK;
  double sum = 0;
  for (std::int32_t i = 0; i < place.n_nodes; ++i) sum += place.weight[i];
  for (std::int32_t i = 0; i < place.n_nodes; ++i) {
    double bound = 0;
    const int said = phn_bound(&model, model.active_nodes[place.active[i]], at.x, &bound);
    if (said < 0) return said;
    status |= said;
    alone.bound = std::fmin(PHN_NO_BOUND, std::fmax(alone.bound, bound / lever));
    evaluate_force(model, model.active[place.active[i]], at.x, force[i].x);
    force[i] /= lever;
    alone.force += (place.weight[i] / sum) * force[i];
  }
  for (std::int32_t i = 0; i < place.n_nodes; ++i)
    alone.spread += place.weight[i] / sum * length((force[i] - alone.force).x);
  return status;
}

/// @param kind  0: one tool; 1: several. The others as in coupled_bound
double bound_of(const phn_model& model, int kind, double own, double bending, double size) {
  const double x[] = {own, bending, size};
  return coupled_bound(model.coupled_bound + kind * phynness::schema::n_coupled_terms, x, PHN_NO_BOUND);
}

/// The bound of one tool that is not coupled. @param status  of all tools
double bound_alone(const phn_model& model, const Place& place, const Alone& alone, int status) {
  if ((status & (PHN_WARNING_OUTSIDE | PHN_WARNING_UNSETTLED)) != 0) return PHN_NO_BOUND;
  if (place.n_nodes == 1 || model.coupled_bound == nullptr) return alone.bound;
  return bound_of(model, 0, alone.bound + alone.spread, alone.spread, length(alone.force.x));
}

/// @return a status of phynness.h
int bound_at(const phn_model* model, const phn_tool* tool, double& bound) {
  if (model == nullptr || tool == nullptr) return PHN_ERROR_ARGUMENT;
  Place place;
  int status = find_place(*model, *tool, place);
  if (status == PHN_OK && !answers_alone(*model, place)) status = PHN_ERROR_UNDEFINED;
  if (status < 0) return status;
  Alone alone;
  Vector d;
  cut(tool->displacement, lever_of(*model, place), PHN_NO_BOUND, d.x);
  status = alone_at(*model, place, d, alone);
  if (status >= 0) bound = bound_alone(*model, place, alone, status);
  return status;
}

/// @param bounds  most_coupled numbers. @return a status of phynness.h
int bounds_of(const phn_model& model, const Coupling& c, double* bounds) {
  Alone alone[most_coupled];
  int status = (c.settled ? PHN_OK : PHN_WARNING_UNSETTLED) | (c.beyond ? PHN_WARNING_OUTSIDE : PHN_OK);
  double size = 0;
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    const HeldPoint& point = c.point[t];
    const bool full = model.coupled_bound != nullptr && c.model == &model;
    if (!full && (c.n_tools > 1 || point.n_nodes > 1)) return PHN_ERROR_UNDEFINED;
    const int said = alone_at(model, point, point.own, alone[t]);
    if (said < 0) return said;
    status |= said;
    size += length(point.force.x);
  }
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    bounds[t] = bound_alone(model, c.point[t], alone[t], status);
    if (c.n_tools == 1 || bounds[t] == PHN_NO_BOUND) continue;
    Vector linear = {};
    double own = 0;
    for (std::int32_t s = 0; s < c.n_tools; ++s) {
      const Matrix& stiffness = c.stiffness[t * c.max_tools + s];
      const Matrix reaches = stiffness * c.point[s].compliance;
      linear += stiffness * c.point[s].own;
      own += std::sqrt(inner_product(reaches, reaches) / 3) * (alone[s].bound + alone[s].spread);
    }
    bounds[t] = bound_of(model, 1, own, length((c.point[t].force - linear).x), size);
  }
  return status;
}

}  // namespace

extern "C" {

int phn_bound_at(const phn_model* model, const phn_tool* tool, double* bound) {
  if (bound == nullptr) return PHN_ERROR_ARGUMENT;
  double found = 0;
  const int status = bound_at(model, tool, found);
  *bound = found;  // the tool has been read
  return status;
}

int phn_coupled_bound(const phn_model* model, const phn_data* data, double* bounds) {
  if (model == nullptr || data == nullptr || data->model != model || bounds == nullptr) return PHN_ERROR_ARGUMENT;
  if (data->coupling == nullptr || data->coupling->n_tools == 0) return PHN_ERROR_UNDEFINED;
  const Coupling& c = *data->coupling;
  double found[most_coupled] = {};
  const int status = bounds_of(*model, c, found);
  for (std::int32_t t = 0; t < c.n_tools; ++t) bounds[t] = status < 0 ? 0 : found[t];
  return status;
}

}  // extern "C"
