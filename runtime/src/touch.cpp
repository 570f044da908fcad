// The C interface to tools anywhere on the surface.
#include "arguments.hpp"
#include "coupled.hpp"
#include "triangle.hpp"

using phynness::runtime::ActiveNode;
using phynness::runtime::Coupling;
using phynness::runtime::finite;
using phynness::runtime::most_coupled;
using phynness::runtime::warnings;
using phynness::runtime::zero;

namespace {

/// Barycentric weights add up to 1 but for this; below it the movable part of a point counts as fixed.
constexpr double weight_slack = 1e-6;

/// The touched nodes of all tools.
struct Touched {
  std::int32_t n = 0, active[3 * most_coupled];
  double weight[most_coupled][3 * most_coupled] = {};

  std::int32_t place(std::int32_t wanted) {
    for (std::int32_t i = 0; i < n; ++i) {
      if (active[i] == wanted) return i;
    }
    active[n] = wanted;
    return n++;
  }
};

/// Checks one tool and adds its nodes.
int add_tool(const phn_model& model, const phn_tool& tool, std::int32_t t, Touched& touched) {
  double sum = 0, movable = 0;
  for (int k = 0; k < 3; ++k) {
    const double w = tool.weights[k];
    if (!(w >= 0 && w <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
    sum += w;
    if (w == 0) continue;
    const std::int32_t active = phynness::runtime::find_active(model, tool.nodes[k]);
    const std::int32_t vertex = phynness::runtime::find_vertex(model, tool.nodes[k]);
    if (active < 0 && vertex < model.n_output) return PHN_ERROR_NOT_ACTIVE;
    if (active < 0) continue;  // fixed
    movable += w;
    touched.weight[t][touched.place(active)] += w;
  }
  if (!(sum >= 1 - weight_slack && sum <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
  if (!(movable > weight_slack)) return PHN_ERROR_NOT_ACTIVE;
  return finite(tool.displacement) ? PHN_OK : PHN_ERROR_NOT_FINITE;
}

/// Whether two tools hold nothing but one and the same node.
bool same_node(const Touched& touched, std::int32_t n_tools) {
  for (std::int32_t i = 0; i < touched.n; ++i) {
    std::int32_t alone = 0;
    for (std::int32_t t = 0; t < n_tools; ++t) {
      double others = 0;
      for (std::int32_t j = 0; j < touched.n; ++j) others += j == i ? 0 : touched.weight[t][j];
      alone += touched.weight[t][i] > 0 && others == 0;
    }
    if (alone > 1) return true;
  }
  return false;
}

double cut(const phn_model& model, double component) {
  using namespace phynness::runtime;
  const double largest =
      model.family == Family::linear ? largest_linear : largest_coupled * model.max_displacement;
  return std::fmax(-largest, std::fmin(largest, component));
}

/// One tool at one node: what that node says, and nothing to solve.
phynness::runtime::CoupledResult single(const phn_model& model, Coupling& c, std::int32_t active, double weight,
                                        const double* target) {
  const ActiveNode& node = model.active[active];
  c.n_tools = c.n_nodes = 1;
  c.active[0] = active;
  for (int k = 0; k < 3; ++k) c.reach[k] = c.displacement[k] = target[k] / weight;
  phynness::runtime::basis_of(model, node, c.reach, c.basis, c.kernel);
  phynness::runtime::basis_gradient_at_rest(model, node, c.rest_gradient, c.kernel);
  phynness::runtime::evaluate_force(model, node, c.displacement, c.force);
  for (int k = 0; k < 3; ++k) c.force[k] /= weight;
  const double energy = phynness::runtime::has_energy(model)
                            ? phynness::runtime::evaluate_energy(model, node, c.displacement)
                            : 0;
  return {true, 0, energy, 0};
}

}  // namespace

extern "C" {

int phn_nearest(const phn_model* model, const double x[3], phn_tool* tool, double point[3]) {
  if (tool != nullptr) *tool = {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
  zero(point, 3);
  if (model == nullptr || x == nullptr || tool == nullptr) return PHN_ERROR_ARGUMENT;
  if (!finite(x)) return PHN_ERROR_NOT_FINITE;
  double least = -1;
  for (std::int32_t t = 0; t < model->n_triangles; ++t) {
    const std::int32_t* vertex = model->triangles + 3 * static_cast<std::size_t>(t);
    const double* corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = phynness::runtime::vertex_point(*model, vertex[k]);
    double weight[3], nearest[3], distance = 0;
    phynness::runtime::nearest_on_triangle(corner, x, weight, nearest, distance);
    if (!(least < 0 || distance < least)) continue;
    least = distance;
    for (int k = 0; k < 3; ++k) {
      tool->nodes[k] = phynness::runtime::vertex_node(*model, vertex[k]);
      tool->weights[k] = weight[k];
      if (point != nullptr) point[k] = nearest[k];
    }
  }
  return least < 0 ? PHN_ERROR_UNDEFINED : PHN_OK;
}

int phn_couple(const phn_model* model, phn_data* data, int32_t n_tools, const phn_tool* tools, double* forces,
               phn_coupled* result) {
  if (result != nullptr) *result = {0, 0, 0};
  if (model == nullptr || data == nullptr || data->model != model || n_tools < 0) return PHN_ERROR_ARGUMENT;
  Coupling& c = data->coupling;
  if (n_tools > 0 && (tools == nullptr || forces == nullptr)) return PHN_ERROR_ARGUMENT;
  for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(n_tools); ++i) forces[i] = 0;
  if (n_tools > c.max_tools) return PHN_ERROR_TOOLS;
  Touched touched;
  double targets[3 * most_coupled];
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const int refused = add_tool(*model, tools[t], t, touched);
    if (refused != PHN_OK) return refused;
    for (int k = 0; k < 3; ++k) targets[3 * t + k] = cut(*model, tools[t].displacement[k]);
  }
  if (same_node(touched, n_tools)) return PHN_ERROR_SAME_NODE;
  const bool alone = n_tools == 1 && touched.n == 1;
  for (std::int32_t i = 0; i < touched.n && !alone; ++i) {
    const ActiveNode& node = model->active[touched.active[i]];
    if (node.output < 0 || !phynness::runtime::has_deformation(*model, node)) return PHN_ERROR_UNDEFINED;
  }
  double weight[most_coupled * 3 * most_coupled] = {};
  for (std::int32_t t = 0; t < n_tools; ++t) {
    for (std::int32_t i = 0; i < touched.n; ++i) weight[t * touched.n + i] = touched.weight[t][i];
  }
  c.n_tools = c.n_nodes = 0;
  if (n_tools == 0) return PHN_OK;
  const auto solved =
      alone ? single(*model, c, touched.active[0], touched.weight[0][0], targets)
            : phynness::runtime::solve_coupled(*model, c, n_tools, touched.n, touched.active, weight, targets);
  int status = solved.settled ? PHN_OK : PHN_WARNING_UNSETTLED;
  for (std::int32_t i = 0; i < touched.n; ++i)
    status |= warnings(*model, model->active[touched.active[i]], c.reach + 3 * i);
  for (std::int32_t i = 0; i < 3 * n_tools; ++i) forces[i] = c.force[i];
  if (result != nullptr) {
    const double energy = std::isfinite(solved.energy) ? solved.energy : 0;
    *result = {solved.residual, energy, solved.iterations};
  }
  return status;
}

int phn_coupled_deform(const phn_model* model, phn_data* data, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  zero(out, 3 * model->n_output);
  if (data == nullptr || data->model != model) return PHN_ERROR_ARGUMENT;
  const Coupling& c = data->coupling;
  for (std::int32_t i = 0; i < c.n_nodes; ++i) {
    if (!phynness::runtime::has_deformation(*model, model->active[c.active[i]])) return PHN_ERROR_UNDEFINED;
  }
  int status = PHN_OK;
  for (std::int32_t i = 0; i < c.n_nodes; ++i)
    status |= warnings(*model, model->active[c.active[i]], c.reach + 3 * i);
  coupled_field(*model, c, data->prepared, data->scratch, data->field, out);
  return status;
}

}  // extern "C"
