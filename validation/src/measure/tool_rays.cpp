#include "tool_rays.hpp"

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/tool_weights.hpp>

namespace phynness {
namespace {

bool same_place(const phn_tool& a, const phn_tool& b) {
  return std::ranges::equal(a.nodes, b.nodes) && std::ranges::equal(a.weights, b.weights);
}

}  // namespace

std::vector<phn_tool> tools_at(const ToolRay& ray, double fraction) {
  auto tools = ray.tools;
  for (auto& tool : tools)
    for (double& x : tool.displacement) x *= fraction;
  return tools;
}

RayForces::RayForces(const DatabaseHeader& header, Variant reference, ShouldStop stop)
    : _header(header),
      _body(variant_body(reference, {stored_scene(header), header.mesh, header.sets})),
      _solver(_body.scene, _body.mesh, _body.sets) {
  _solver.set_stop(std::move(stop));
}

/// Finds the place of a tool on the mesh of the variant, whose triangles may be smaller.
SurfacePoint RayForces::point_of(const phn_tool& tool) const {
  SurfacePoint point;
  Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    point.nodes[k] = tool.nodes[k] < 0 ? tool.nodes[0] : tool.nodes[k];
    point.weights[k] = tool.weights[k];
    x += point.weights[k] * _body.mesh.nodes.row(point.nodes[k]);
  }
  if (_body.mesh.n_nodes() == _header.mesh.n_nodes() || std::ranges::max(point.weights) == 1) return point;
  return nearest_on_surface(_body.mesh.nodes, _body.mesh.surface, {x[0], x[1], x[2]});
}

std::vector<Vec3> RayForces::solve(const ToolRay& ray) {
  std::vector<Vec3> forces, displacements;
  std::vector<SurfacePoint> points;
  for (const auto& tool : ray.tools) {
    points.push_back(point_of(tool));
    displacements.push_back({tool.displacement[0], tool.displacement[1], tool.displacement[2]});
  }
  try {
    if (!std::ranges::equal(ray.tools, _touched_tools, same_place)) {
      _touched_tools.clear();
      _solver.touch_points(points);
      _touched_tools = ray.tools;
    }
    if (ray.fractions.empty())
      for (const auto& column : _solver.rest().stiffness_N_per_m.colwise())
        forces.push_back({column[0], column[1], column[2]});
    _solver.follow(displacements, ray.fractions, false, [&](std::size_t, const Response& response) {
      if (response.status != Status::converged) return false;
      forces.insert(forces.end(), response.force_N.begin(), response.force_N.end());
      return true;
    });
  } catch (const Error&) {  // tools are at one place, or a tangent is singular
    _solver.recover();
    _touched_tools.clear();
  }
  return forces;
}

}  // namespace phynness
