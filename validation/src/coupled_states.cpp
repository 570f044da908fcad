#include "coupled_states.hpp"

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/validation/probe_plan.hpp>

namespace phynness {
namespace {

constexpr std::size_t states_of_ray = 3;
/// Pairs that are near are no farther from each other than this, in radii of the tool.
constexpr double near_radii = 2.5;

}  // namespace

CoupledRays::CoupledRays(const LoadedModel& model, const ProbeSpec& probe)
    : _model(model), _triangles(answered_triangles(model)), _near_m(near_radii * probe.tool_radius_m) {}

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
  phn_trusted trusted{};
  if (_model.runtime().trust(moved, trusted) >= 0) return trusted.trained_depth;
  double depth = _model.model().max_displacement_m;  // a tool between the nodes of a model without round tools
  for (int k = 0; k < 3; ++k)
    if (tool.weights[k] > 0) depth = std::min(depth, _model.trained_depth(tool.nodes[k], e));
  return depth;
}

bool CoupledRays::displace(std::mt19937_64& random, phn_tool& tool) const {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const Vec3 e = on_sphere(random);
    const double depth = trained_depth(tool, e) * (1 - uniform(random));
    for (std::size_t k = 0; k < 3; ++k) tool.displacement[k] = depth * e[k];
    if (depth > 0) return true;
  }
  return false;
}

void CoupledRays::solve(ProbeSolver& solver, std::mt19937_64& random, std::int32_t ray, std::int32_t n_tools,
                        std::vector<CoupledState>& states) const {
  std::vector<phn_tool> tools;
  const bool at_nodes = n_tools > 1 && ray % 2 == 0, near = ray % 3 == 0 && _near_m > 0;
  for (int attempt = 0; attempt < 1000 && std::ssize(tools) < n_tools; ++attempt) {
    phn_tool tool = random_tool(random, at_nodes);
    const double away = tools.empty() ? 1 : (place(tool) - place(tools[0])).norm();
    const bool fits = away > 0 && (tools.empty() || !near || away < _near_m);
    if (fits && displace(random, tool)) tools.push_back(tool);
  }
  if (std::ssize(tools) < n_tools) return;
  std::vector<SurfacePoint> points;
  std::vector<Vec3> d;
  for (const auto& tool : tools) {
    SurfacePoint point;
    for (std::size_t k = 0; k < 3; ++k) {
      point.nodes[k] = tool.nodes[k] < 0 ? tool.nodes[0] : tool.nodes[k];
      point.weights[k] = tool.weights[k];
    }
    points.push_back(point);
    d.push_back({tool.displacement[0], tool.displacement[1], tool.displacement[2]});
  }
  std::vector<double> parts;
  for (std::size_t i = 0; i < states_of_ray; ++i) parts.push_back(1 - uniform(random));
  std::sort(parts.begin(), parts.end());
  try {
    _model.couple(tools);  // refused by a model of forces only
    solver.touch_points(points);
    solver.follow(d, parts, false, [&](std::size_t i, const Response& response) {
      if (response.status != Status::converged) return false;
      CoupledState state{ray, n_tools, {}, {}};
      for (std::size_t t = 0; t < tools.size(); ++t) {
        state.tools[t] = tools[t];
        for (double& x : state.tools[t].displacement) x *= parts[i];
        state.force_N[t] = response.force_N.at(t);
      }
      states.push_back(state);
      return true;
    });
  } catch (const Error&) {  // also of tools at one place, or if a tangent is not factorized
    solver.recover();
  }
}

}  // namespace phynness
