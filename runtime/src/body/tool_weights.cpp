// The mean displacement under a round tool anywhere on the surface.
#include <phynness/schema/round_tool.hpp>

#include "body/body.hpp"
#include "tools/round_tool.hpp"

namespace PHN_RUNTIME {
namespace {

/// Tolerance of the sum of barycentric weights, and the weight up to which a corner does not count.
constexpr double weight_tolerance = 1e-6, negligible_weight = 1e-12;
/// Largest weight of the fixed corners of a triangle for which a tool has no warning.
constexpr double largest_weight_at_fixed = 0.3;

/// Sums of weights at the nodes that can move.
struct Sum {
  const phn_body& body;
  ToolScratch& scratch;
  std::int32_t n = 0;

  void add(std::int32_t node, double weight) {
    if (body.node_kinds[node] == schema::body_node_fixed || !(weight > 0)) return;
    if (scratch.weight[node] == 0) scratch.weighted_nodes[n++] = node;
    scratch.weight[node] += weight;
  }
};

/// Weights of the mean displacement under a tool: scratch.weight at the first n of scratch.weighted_nodes. @param n
/// output
/// @return PHN_OK, PHN_WARNING_OUTSIDE or an error
int tool_weights(const phn_body& body, const phn_tool& tool, ToolScratch& scratch, std::int32_t& n) {
  std::int32_t corner[3];
  double share[3], sum = 0, fixed = 0, at_fixed = 0;
  bool is_trained = true;
  n = 0;
  if (!is_of_this_version(tool)) return PHN_ERROR_VERSION;
  for (int k = 0; k < 3; ++k) {
    const double w = tool.weights[k];
    if (!(w >= -weight_tolerance && w <= 1 + weight_tolerance)) return PHN_ERROR_ARGUMENT;
    sum += w;
    share[k] = w > negligible_weight ? w : 0;
    corner[k] = share[k] > 0 ? find_sorted(body.info.nodes, body.info.n_nodes, tool.nodes[k]) : 0;
    if (corner[k] < 0) return PHN_ERROR_ARGUMENT;
    if (share[k] > 0 && body.node_kinds[corner[k]] == schema::body_node_fixed) fixed += w;
    if (share[k] > 0 && body.node_kinds[corner[k]] == schema::body_node_moves) is_trained = false;
  }
  if (!(sum >= 1 - weight_tolerance && sum <= 1 + weight_tolerance)) return PHN_ERROR_ARGUMENT;
  if (!finite(tool.displacement)) return PHN_ERROR_NOT_FINITE;
  Sum all{body, scratch};
  if (body.info.tool_radius_m > 0) {
    const schema::ToolSurface surface{body.info.points, body.normals, body.info.triangles, body.neighbors,
                                      body.info.n_triangles};
    schema::integrate_pressure<3>(surface, {scratch.is_reached, scratch.reached}, corner, share,
                                  body.info.tool_radius_m, [&](std::int32_t t, const double* integrals) {
                                    const std::int32_t* node = body.info.triangles + 3 * t;
                                    for (int k = 0; k < 3; ++k) all.add(node[k], integrals[k]);
                                    at_fixed += schema::integrals_at_fixed(integrals, [&](int k) {
                                      return body.node_kinds[node[k]] == schema::body_node_fixed;
                                    });
                                  });
  } else {
    for (int k = 0; k < 3; ++k) all.add(corner[k], share[k]);
  }
  n = all.n;
  double total = 0;
  for (std::int32_t i = 0; i < n; ++i) total += scratch.weight[scratch.weighted_nodes[i]];
  if (!(total > 0)) return PHN_ERROR_NOT_ACTIVE;
  const double divisor = schema::weight_divisor(total, at_fixed);
  for (std::int32_t i = 0; i < n; ++i) scratch.weight[scratch.weighted_nodes[i]] /= divisor;
  return is_trained && fixed <= largest_weight_at_fixed ? PHN_OK : PHN_WARNING_OUTSIDE;
}

}  // namespace

int set_constraint_rows(phn_body_state& state, const phn_tool& tool, double* rows) {
  const phn_body& body = *state.body;
  const std::int32_t n_rows = 3 * body.stride;
  std::int32_t n = 0;
  const int status = tool_weights(body, tool, state.scratch, n);
  set_zero(rows, static_cast<std::size_t>(n_rows));
  for (std::int32_t t = 0; t < n; ++t) {
    const std::int32_t node = state.scratch.weighted_nodes[t];
    const float* modes = body.modes[3 * static_cast<std::int64_t>(node)];
    double& weight = state.scratch.weight[node];
    for (std::int32_t m = 0; m < n_rows; ++m) rows[m] += weight * modes[m];
    weight = 0;
  }
  return status;
}

}  // namespace PHN_RUNTIME
