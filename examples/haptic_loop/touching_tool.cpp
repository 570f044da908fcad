#include "touching_tool.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace {

Vector3 cross(Vector3 a, Vector3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/// Point of a vertex of the surface. Vertices are the output nodes, followed by fixed nodes.
Vector3 point_of(const phn_info& model, int32_t vertex) {
  const int32_t n = model.n_output;
  const double* x = vertex < n ? model.output_points + 3 * vertex : model.fixed_points + 3 * (vertex - n);
  return {x[0], x[1], x[2]};
}

}  // namespace

TouchingTool::TouchingTool(const TouchingSettings& settings, const phn_model* of, phn_data* data, phn_contact* contact,
                           int32_t node)
    : _settings(settings), _data(data), _contact(contact) {
  phn_info model;
  phn_model_info(of, &model);
  int32_t vertex = 0;
  while (vertex < model.n_output && model.output_nodes[vertex] != node) ++vertex;
  Vector3 normal;
  const int32_t* corner = model.triangles;
  for (int32_t t = 0; t < model.n_triangles; ++t, corner += 3) {
    if (corner[0] != vertex && corner[1] != vertex && corner[2] != vertex) continue;
    const Vector3 a = point_of(model, corner[0]);
    normal = normal + cross(point_of(model, corner[1]) - a, point_of(model, corner[2]) - a);
  }
  if (vertex == model.n_output || !(length(normal) > 0))
    throw std::invalid_argument("node " + std::to_string(node) +
                                " is not a vertex of the surface, which --contact needs as its start");
  _axis[2] = (1 / length(normal)) * normal;
  const Vector3 aside = std::abs(_axis[2].x) < 0.7 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  const Vector3 along = aside - dot(aside, _axis[2]) * _axis[2];
  _axis[0] = (1 / length(along)) * along;
  _axis[1] = cross(_axis[2], _axis[0]);
  _origin = point_of(model, vertex) + (settings.radius_m + settings.clearance_m) * _axis[2];
  for (int32_t& n : _state.held.nodes) n = -1;
}

Vector3 TouchingTool::follow(Vector3 position, Vector3 tool, double coupling, double deepest) {
  const Vector3 center = _origin + to_body(tool);
  const phn_contact_tool sphere = {
      {center.x, center.y, center.z}, _settings.radius_m, _settings.friction, PHN_TOOL_PRESS, 0};
  const bool before = in_contact();
  _status = phn_contact_step(_contact, _data, 1, &sphere, &_state, nullptr);
  // Without contact no force acts on the sphere.
  if (_status < 0 || !in_contact()) return position;
  _touches += !before;
  ++_in_contact;
  const Vector3 force = to_device(_state.force), pushed_in = to_device(_state.held.displacement);
  const double depth2 = dot(pushed_in, pushed_in);
  // Secant stiffness of the tissue from rest. The iteration converges if the tangent stiffness of the tissue is at most
  // twice the sum of this stiffness and that of the coupling.
  const double stiffness = depth2 > 0 ? std::fmax(0.0, dot(force, pushed_in) / depth2) : 0;
  Vector3 step = (1 / (coupling + stiffness)) * (coupling * (position - tool) - force);
  const double depth = length(pushed_in + step);
  if (deepest > 0 && depth > deepest) step = (deepest / depth) * (pushed_in + step) - pushed_in;
  return tool + step;
}
