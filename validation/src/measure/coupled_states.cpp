#include "coupled_states.hpp"

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/validation/probe_plan.hpp>

namespace phynness {
namespace {

/// Largest number of draws of a ray. If nine states of ten are flagged, two rays in a thousand find no state.
constexpr int max_draws = 60;
/// Largest distance of near tools from the first one, in tool radii.
constexpr double near_radii = 2.5;

}  // namespace

CoupledRays::CoupledRays(const NamedOrgan& model, const ProbeSpec& probe, const NamedOrgan* body)
    : _model(model),
      _body(body),
      _increments(probe.increments),
      _triangles(triangles_by_corners(model)[3]),
      _near_m(near_radii * probe.tool_radius_m) {}

bool CoupledRays::is_possible(CoupledKind kind) const {
  return kind == CoupledKind::one ? !_triangles.empty() : _model.model().nodes.size() > 1;
}

phn_tool CoupledRays::draw_place(std::mt19937_64& random, bool at_node) const {
  if (at_node || _triangles.empty())
    return {{random_element(_model.model().nodes, random).node, -1, -1}, {1, 0, 0}, {}};
  phn_tool tool{};
  const auto t = random_element(_triangles, random);
  const auto weights = random_barycentric(random);
  for (int k = 0; k < 3; ++k) {
    tool.nodes[k] = _model.model().surface(t, k);
    tool.weights[k] = weights[static_cast<std::size_t>(k)];
  }
  return tool;
}

Eigen::RowVector3d CoupledRays::position_of(const phn_tool& tool) const {
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

double CoupledRays::draw_displacement(std::mt19937_64& random, phn_tool& tool) const {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const Vec3 e = random_direction(random);
    const double trained = trained_depth(tool, e), fraction = 1 - uniform(random);
    const double depth = fraction * (_body && trained > 0 ? _model.model().max_displacement_m : trained);
    for (std::size_t k = 0; k < 3; ++k) tool.displacement[k] = depth * e[k];
    if (depth > 0) return fraction;
  }
  return 0;
}

ToolRay CoupledRays::draw_candidate(std::mt19937_64& random, std::int32_t n_tools, bool at_nodes, bool near) const {
  ToolRay ray;
  double largest_fraction = 0;
  for (int attempt = 0; attempt < 1000 && std::ssize(ray.tools) < n_tools; ++attempt) {
    phn_tool tool = draw_place(random, at_nodes);
    const auto distance_to = [&](const phn_tool& other) { return (position_of(tool) - position_of(other)).norm(); };
    if (std::ranges::any_of(ray.tools, [&](const auto& other) { return !(distance_to(other) > 0); })) continue;
    if (near && !ray.tools.empty() && distance_to(ray.tools[0]) >= _near_m) continue;
    const double fraction = draw_displacement(random, tool);
    if (fraction > 0) ray.tools.push_back(tool);
    largest_fraction = std::max(largest_fraction, fraction);
  }
  ray.tools = tools_at(ray, 1 / largest_fraction);
  for (const double half : {0.0, 0.5})  // the largest of n independent numbers is below x with the probability x^n
    ray.fractions.push_back(std::pow(half + (1 - uniform(random)) / 2, 1.0 / n_tools));
  return ray;
}

DrawnRay CoupledRays::without_flagged(const ToolRay& ray, DrawnStates& drawn) const {
  DrawnRay unflagged{{ray.tools, {}}, {}};
  if (_body) _body->organ().reset().ignore();
  double reached = 0;
  for (const double fraction : ray.fractions) {
    OrganResponse response;
    const auto n = _body ? static_cast<int>(std::ceil(_increments * (fraction - reached) / ray.fractions.back())) : 1;
    for (int i = 1; i <= n; ++i)
      response = (_body ? _body : &_model)->hold(tools_at(ray, reached + (fraction - reached) * i / n));
    reached = fraction;
    const bool flagged = (response.status & (PHN_WARNING_OUTSIDE | PHN_WARNING_UNSETTLED | PHN_WARNING_NEAR)) != 0;
    drawn.all += 1;
    drawn.flagged += flagged;
    drawn.unsettled += (response.status & PHN_WARNING_UNSETTLED) != 0;
    if (flagged) continue;
    unflagged.fractions.push_back(fraction);
    const auto tools = tools_at(ray, fraction);
    std::array<double, 3> terms[PHN_MOST_COUPLED] = {};
    const auto n_tools = static_cast<std::int32_t>(tools.size());
    if (_body) phn_body_bound_terms(_body->organ().body(), _body->organ().state(), n_tools, terms[0].data());
    for (std::size_t t = 0; t < tools.size(); ++t)
      unflagged.states.push_back({0, CoupledKind::one, n_tools, tools[t], {}, *response.force_N[t], terms[t]});
  }
  return unflagged;
}

DrawnRay CoupledRays::draw(std::mt19937_64& random, std::int32_t number, CoupledKind kind, DrawnStates& drawn) const {
  const std::int32_t n_tools = kind == CoupledKind::one ? 1 : 2 + number / 6 % 2;  // 6: at nodes or not, near or not
  const bool at_nodes = n_tools > 1 && number % 2 == 0, near = number % 3 == 0 && _near_m > 0;
  for (int attempt = 0; attempt < max_draws; ++attempt) {
    const ToolRay ray = draw_candidate(random, n_tools, at_nodes, near && attempt < max_draws / 2);
    if (std::ssize(ray.tools) < n_tools) continue;
    try {
      auto unflagged = without_flagged(ray, drawn);
      for (auto& state : unflagged.states) state.ray = number, state.kind = kind;
      if (!unflagged.fractions.empty()) return unflagged;
    } catch (const Error&) {  // the model has forces only, or a node without output
    }
  }
  return {};
}

}  // namespace phynness
