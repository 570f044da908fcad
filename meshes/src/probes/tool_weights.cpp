#include <phynness/meshes/tool_weights.hpp>

#include <algorithm>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/schema/round_tool.hpp>

namespace phynness {

SurfaceTools::SurfaceTools(const Points& nodes, const Triangles& surface)
    : _nodes(nodes),
      _surface(surface),
      _normals(node_normals(nodes, surface)),
      _across(static_cast<std::size_t>(surface.size())),
      _reached(static_cast<std::size_t>(surface.rows())),
      _taken(static_cast<std::size_t>(surface.rows()), 0) {
  std::vector<std::int32_t> last_at(static_cast<std::size_t>(nodes.rows())), before(_across.size());
  schema::set_across(surface.data(), static_cast<std::int32_t>(surface.rows()), static_cast<std::int32_t>(nodes.rows()),
                     last_at.data(), before.data(), _across.data());
}

void SurfaceTools::press(const SurfacePoint& center, double radius, bool quadratic, const TakeIntegrals& take) {
  const schema::ToolSurface surface{_nodes.data(), _normals.data(), _surface.data(), _across.data(),
                                    static_cast<std::int32_t>(_surface.rows())};
  const auto press = [&](auto n_functions) {
    schema::press<n_functions>(surface, {_taken.data(), _reached.data()}, center.nodes.data(), center.weights.data(),
                               radius, [&](std::int32_t t, const double* integrals) {
                                 take(t, {integrals, static_cast<std::size_t>(n_functions)});
                               });
  };
  if (quadratic)
    press(std::integral_constant<int, 6>());
  else
    press(std::integral_constant<int, 3>());
}

TouchedNodes SurfaceTools::touched_nodes(std::span<const std::int32_t> fixed, const SurfacePoint& center,
                                         double radius) {
  std::map<std::int32_t, double> weight;
  if (radius > 0)
    press(center, radius, false, [&](Eigen::Index t, std::span<const double> integrals) {
      for (std::size_t k = 0; k < 3; ++k)
        if (integrals[k] > 0) weight[_surface(t, static_cast<Eigen::Index>(k))] += integrals[k];
    });
  else
    for (std::size_t k = 0; k < 3; ++k)
      if (center.weights[k] > 0) weight[center.nodes[k]] += center.weights[k];
  TouchedNodes touched;
  touched.mean = radius > 0;
  double sum = 0;
  for (const auto& [node, w] : weight)
    if (!std::binary_search(fixed.begin(), fixed.end(), node)) {
      touched.nodes.push_back(node);
      touched.weights.push_back(w);
      sum += w;
    }
  if (!(sum > 0)) throw input_error("all nodes of a tool are fixed", "", "touch a part of the surface that can move");
  if (touched.mean)
    for (auto& w : touched.weights) w /= sum;
  return touched;
}

TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           const SurfacePoint& center, double radius) {
  return SurfaceTools(nodes, surface).touched_nodes(fixed, center, radius);
}

std::vector<TouchedNodes> tools_of(const Mesh& mesh, const std::vector<std::int32_t>& fixed,
                                   const std::vector<std::int32_t>& nodes, double radius) {
  SurfaceTools tools(mesh.nodes, mesh.surface);
  std::vector<TouchedNodes> all;
  for (const auto node : nodes) all.push_back(tools.touched_nodes(fixed, at_node(node), radius));
  return all;
}

}  // namespace phynness
