#include "coupled_states.hpp"

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>

namespace phynness {
namespace {

/// Largest number of draws of a ray. If nine states of ten are flagged, two rays in a thousand find no state.
constexpr int max_draws = 60;
/// Largest distance of near tools from the first one, in tool radii.
constexpr double near_radii = 2.5;

}  // namespace

CoupledRays::CoupledRays(const NamedOrgan& model, const ProbeSpec& probe, const NamedOrgan* body)
    : _model(model), _body(body), _places(RandomPlaces::answered(model, body)), _probe(probe) {}

bool CoupledRays::is_possible(CoupledKind kind) const {
  return kind == CoupledKind::one ? !_places.at_nodes() : _model.model().nodes.size() > 1;
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

double CoupledRays::draw_displacement(std::mt19937_64& random, const SurfacePoint& place, phn_tool& tool) const {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const Vec3 e = _body ? _places.draw_direction(random, _probe.directions, place) : random_direction(random);
    const double range = _body ? _body->body_info().max_displacement_m : trained_depth(tool, e),
                 fraction = 1 - uniform(random);
    for (std::size_t k = 0; k < 3; ++k) tool.displacement[k] = fraction * range * e[k];
    if (range > 0) return fraction;
  }
  return 0;
}

ToolRay CoupledRays::draw_candidate(std::mt19937_64& random, std::int32_t n_tools, bool near) const {
  ToolRay ray;
  std::vector<Eigen::Vector3d> points;
  double largest_fraction = 0;
  for (int attempt = 0; attempt < 1000 && std::ssize(ray.tools) < n_tools; ++attempt) {
    const SurfacePoint place = _places.draw(random);
    const Eigen::Vector3d x = to_eigen(place.point);
    if (std::ranges::any_of(points, [&](const auto& other) { return x == other; })) continue;
    if (near && !points.empty() && (x - points[0]).norm() >= near_radii * _probe.tool_radius_m) continue;
    phn_tool tool = tool_at(place, {});
    const double fraction = draw_displacement(random, place, tool);
    if (!(fraction > 0)) continue;
    ray.tools.push_back(tool);
    points.push_back(x);
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
    const auto n =
        _body ? static_cast<int>(std::ceil(_probe.increments * (fraction - reached) / ray.fractions.back())) : 1;
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
  const std::int32_t n_tools = kind == CoupledKind::one ? 1 : 2 + number / 3 % 2;
  const bool near = number % 3 == 0 && _probe.tool_radius_m > 0;
  for (int attempt = 0; attempt < max_draws; ++attempt) {
    const ToolRay ray = draw_candidate(random, n_tools, near && attempt < max_draws / 2);
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
