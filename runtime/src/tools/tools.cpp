// The C interface of phynness_tools.h: the answers of one tool anywhere, and of several.
#include <phynness/phynness_tools.h>

#include "tools/coupled.hpp"

using namespace PHN_RUNTIME;

namespace {

/// The warnings of a node of a tool at a displacement [m].
int warnings_at(const phn_model& model, std::int32_t active, const Vector& d) {
  return warnings(model, model.active[active], d.x);
}

/// Computes the response of one tool at one node, or of one round tool: the mean of the responses around it.
CoupledResult solve_single(const phn_model& model, Coupling& c, const Vector& target) {
  Constraint& point = c.point[0];
  const Mean mean = mean_at(model, c.neighbours, point);
  c.n_sets = 1;
  c.field_rotation[0] = {};
  point.displacement = target;
  double energy = 0;
  respond_as_mean(model, mean, target, point.force, model.has_energy ? &energy : nullptr, nullptr);
  const Vector d = target / mean.transmission;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& node = model.active[point.active[i]];
    c.field(0, 0, i) = {mean.share[i], d};
    if (point.counts(i))
      c.warnings |= warnings_at(*model.full, point.active[i], diagonal(1 / mean.transmission) * target);
    if (!has_deformation(model, node)) continue;
    double* basis = c.field_basis(0, 0, i);
    basis_of(model, node, d.x, basis, c.kernel_scratch);
    for (std::int32_t j = 0; j < basis_size(model, node); ++j) basis[j] *= mean.share[i];
  }
  if (is_beside_fixed(model, point)) c.warnings |= PHN_WARNING_OUTSIDE;
  return {true, 0, energy};
}

CoupledResult solve_several(const phn_model& model, Coupling& c, const Vector* targets) {
  const CoupledResult solved = solve_coupled(model, c, targets);
  for (std::int32_t t = 0; t < c.n_tools; ++t) {
    const Constraint& point = c.point[t];
    for (std::int32_t i = 0; i < point.n_nodes; ++i)
      c.warnings |= warnings_at(*model.full, point.active[i], point.node_displacement[i] * point.displacement);
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

}  // namespace

namespace PHN_RUNTIME {

double largest_between_nodes(const phn_model& model) {
  return schema::traits(model.kind).proportional ? largest_linear : largest_coupled * model.max_displacement_m;
}

int couple_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const phn_tool* tools,
                 phn_coupled& result) {
  if (n_tools > most_coupled) return PHN_ERROR_TOO_MANY_TOOLS;
  if (n_tools > data.max_tools) return PHN_ERROR_TOOLS;
  Coupling& c = *data.coupling;
  c.n_tools = 0;
  c.warnings = PHN_OK;
  if (n_tools > 1 && has_round_tools(c)) return PHN_ERROR_ROUND_TOOLS;
  const double largest = largest_between_nodes(model);
  Vector targets[most_coupled];
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int refused = find_place(model, tools[t], c.point[t]);
    if (refused != PHN_OK) return refused;
    clamp(tools[t].displacement, 1, largest, targets[t].x);
  }
  c.model = data.level;
  if (n_tools == 0) return PHN_OK;
  const bool is_single = n_tools == 1 && needs_no_coupling(model, c.point[0]);
  if (!is_single && (has_round_tools(c) || !can_couple(*c.model, c, n_tools))) return PHN_ERROR_UNDEFINED;
  c.n_tools = n_tools;
  const CoupledResult solved = is_single ? solve_single(*c.model, c, targets[0]) : solve_several(*c.model, c, targets);
  result = {solved.residual, std::isfinite(solved.energy) ? solved.energy : 0};
  return solved.settled ? c.warnings : c.warnings | PHN_WARNING_UNSETTLED;
}

int field_of_tools(const phn_model& model, phn_data& data, double* out) {
  const Coupling& c = *data.coupling;
  for (std::int32_t t = 0; t < c.n_tools; ++t)
    for (std::int32_t i = 0; i < c.point[t].n_nodes; ++i)
      if (!has_deformation(model, model.active[c.point[t].active[i]])) return PHN_ERROR_UNDEFINED;
  coupled_field(*c.model, c, data.prepared, data.scratch, data.field, out);
  // Sums of the fields of several nodes overflow where a model has numbers near the largest.
  for (std::int32_t i = 0; i < 3 * model.n_output; ++i) out[i] = std::isfinite(out[i]) ? out[i] : 0;
  return c.warnings;
}

}  // namespace PHN_RUNTIME

extern "C" {

int phn_couple(const phn_model* model, phn_data* data, int32_t n_tools, const phn_tool* tools, double* forces,
               phn_coupled* result) {
  phn_coupled coupled = {0, 0};
  int status = PHN_ERROR_ARGUMENT;
  if (overlap(forces, n_tools > 0 ? 3 * sizeof *forces * static_cast<std::size_t>(n_tools) : 0, result,
              sizeof *result)) {
    status = PHN_ERROR_OVERLAP;
  } else if (n_tools >= 0 && model != nullptr && data != nullptr && data->model == model &&
             (n_tools == 0 || (tools != nullptr && forces != nullptr))) {
    status = couple_tools(*model, *data, n_tools, tools, coupled);
  }
  // The tools have been read; the forces may overlap them.
  for (std::int32_t t = 0; forces != nullptr && t < n_tools; ++t)
    for (int k = 0; k < 3; ++k) *forces++ = status < 0 ? 0 : data->coupling->point[t].force[k];
  if (result != nullptr) *result = coupled;
  return status;
}

int phn_coupled_deform(const phn_model* model, phn_data* data, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  zero(out, 3 * model->n_output);
  if (data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  return field_of_tools(*model, *data, out);
}

}  // extern "C"
