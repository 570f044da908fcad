// Bounds of the force's error of tools between nodes (formats/model.md, Bounds).
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

/// @param status  the warnings
double bound_alone(const phn_model& model, const Place& place, const Alone& alone, int status) {
  if ((status & (PHN_WARNING_OUTSIDE | PHN_WARNING_UNSETTLED)) != 0) return PHN_NO_BOUND;
  if (place.n_nodes == 1) return alone.bound;
  const double x[] = {alone.bound + alone.spread, alone.spread, length(alone.force.x)};
  return coupled_bound(model.bound_between, x, PHN_NO_BOUND);
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

/// @return a status of phynness.h
int bound_of(const phn_model& model, const Coupling& c, double& bound) {
  const Constraint& point = c.point[0];
  if (c.n_tools > 1 || (point.n_nodes > 1 && c.model != &model)) return PHN_ERROR_UNDEFINED;
  Alone alone;
  const int said = alone_at(model, point, point.own, alone);
  if (said < 0) return said;
  const int status = said | (c.settled ? PHN_OK : PHN_WARNING_UNSETTLED);
  bound = bound_alone(model, point, alone, status);
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
  const int status = bound_of(*model, c, found[0]);
  for (std::int32_t t = 0; t < c.n_tools; ++t) bounds[t] = status < 0 ? 0 : found[t];
  return status;
}

}  // extern "C"
