#include "coupled_states.hpp"

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/validation/probe_plan.hpp>

#include "body_predictions.hpp"

namespace phynness {
namespace {

/// Of a ray. A draw takes less than a thousandth of a solve.
constexpr int most_draws = 200;
/// Pairs that are near are no farther from each other than this, in radii of the tool.
constexpr double near_radii = 2.5;

}  // namespace

CoupledRays::CoupledRays(const NamedOrgan& model, const ProbeSpec& probe, const NamedOrgan* body)
    : _model(model),
      _body(body),
      _increments(probe.increments),
      _triangles(triangles_by_corners(model)[3]),
      _near_m(near_radii * probe.tool_radius_m) {}

bool CoupledRays::possible(int n_tools) const {
  return n_tools == 1 ? !_triangles.empty() : _model.model().nodes.size() > 1;
}

phn_tool CoupledRays::random_tool(std::mt19937_64& random, bool at_node) const {
  const auto one_of = [&](const auto& list) {
    return list[static_cast<std::size_t>(uniform(random) * static_cast<double>(list.size()))];
  };
  if (at_node || _triangles.empty()) return {{one_of(_model.model().nodes).node, -1, -1}, {1, 0, 0}, {}};
  phn_tool tool{};
  const auto t = one_of(_triangles);
  const auto weights = point_of_triangle(random);
  for (int k = 0; k < 3; ++k) {
    tool.nodes[k] = _model.model().surface(t, k);
    tool.weights[k] = weights[static_cast<std::size_t>(k)];
  }
  return tool;
}

Eigen::RowVector3d CoupledRays::place(const phn_tool& tool) const {
  Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (tool.weights[k] > 0) x += tool.weights[k] * _model.mesh().nodes.row(tool.nodes[k]);
  return x;
}

double CoupledRays::trained_depth(const phn_tool& tool, const Vec3& e) const {
  phn_tool moved = tool;
  for (std::size_t k = 0; k < 3; ++k) moved.displacement[k] = 1e-6 * _model.model().max_displacement_m * e[k];
  double depth_m = 0;
  if (_model.organ().depth(moved, depth_m) >= 0) return depth_m;
  double depth = _model.model().max_displacement_m;  // a tool between the nodes of a model without round tools
  for (int k = 0; k < 3; ++k)
    if (tool.weights[k] > 0) depth = std::min(depth, _model.trained_depth(tool.nodes[k], e));
  return depth;
}

bool CoupledRays::displace(std::mt19937_64& random, phn_tool& tool) const {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const Vec3 e = on_sphere(random);
    const double trained = trained_depth(tool, e), all = _model.model().max_displacement_m;
    const double depth = (_body && trained > 0 ? all : trained) * (1 - uniform(random));
    for (std::size_t k = 0; k < 3; ++k) tool.displacement[k] = depth * e[k];
    if (depth > 0) return true;
  }
  return false;
}

bool CoupledRays::is_flagged(const std::vector<phn_tool>& tools) const {
  const int status = _body ? _body->hold_from_rest(tools, _increments).status : _model.hold(tools).status;
  return (status & (PHN_WARNING_OUTSIDE | PHN_WARNING_UNSETTLED | PHN_WARNING_NEAR)) != 0;
}

ToolRay CoupledRays::draw_any(std::mt19937_64& random, std::int32_t n_tools, bool at_nodes, bool near) const {
  ToolRay ray{{}, {1}};
  for (int attempt = 0; attempt < 1000 && std::ssize(ray.tools) < n_tools; ++attempt) {
    phn_tool tool = random_tool(random, at_nodes);
    const double away = ray.tools.empty() ? 1 : (place(tool) - place(ray.tools[0])).norm();
    if (!(away > 0 && (ray.tools.empty() || !near || away < _near_m))) continue;
    if (displace(random, tool)) ray.tools.push_back(tool);
  }
  return ray;
}

ToolRay CoupledRays::draw(std::mt19937_64& random, std::int32_t number, std::int32_t n_tools,
                          DrawnStates& drawn) const {
  const bool at_nodes = n_tools > 1 && number % 2 == 0, near = number % 3 == 0 && _near_m > 0;
  for (int attempt = 0; attempt < most_draws; ++attempt) {
    ToolRay ray = draw_any(random, n_tools, at_nodes, near && attempt < most_draws / 2);
    if (std::ssize(ray.tools) < n_tools) continue;
    try {
      const bool flagged = is_flagged(ray.tools);
      drawn.all += 1;
      drawn.flagged += flagged;
      if (!flagged) return ray;
    } catch (const Error&) {  // of a model of forces only, or a node without output
    }
  }
  return {};
}

}  // namespace phynness
