#include <phynness/meshes/tool_weights.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/schema/round_tool.hpp>

namespace phynness {
namespace {

using Vector = Eigen::Vector3d;

/// Weights of the nearest point of the segment from corner i to corner j.
Vector on_edge(const Eigen::Matrix3d& corners, int i, int j, const Vector& x) {
  const Vector along = corners.col(j) - corners.col(i);
  const double square = along.squaredNorm();
  const double t = square > 0 ? std::clamp(along.dot(x - corners.col(i)) / square, 0.0, 1.0) : 0.0;
  Vector weights = Vector::Zero();
  weights[i] = 1 - t;
  weights[j] += t;
  return weights;
}

}  // namespace

Eigen::Vector3d nearest_in_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& x) {
  const Vector a = corners.col(1) - corners.col(0), b = corners.col(2) - corners.col(0), c = x - corners.col(0);
  const double aa = a.squaredNorm(), ab = a.dot(b), bb = b.squaredNorm(), determinant = aa * bb - ab * ab;
  if (determinant > 0) {
    const double s = (bb * a.dot(c) - ab * b.dot(c)) / determinant, t = (aa * b.dot(c) - ab * a.dot(c)) / determinant;
    if (s >= 0 && t >= 0 && s + t <= 1) return {1 - s - t, s, t};
  }
  Vector best = on_edge(corners, 0, 1, x);
  for (const auto& weights : {on_edge(corners, 1, 2, x), on_edge(corners, 2, 0, x)})
    if ((corners * weights - x).norm() < (corners * best - x).norm()) best = weights;
  return best;
}

Eigen::Matrix3d corners_of(const Points& nodes, const Triangles& surface, Eigen::Index t) {
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k) corners.col(k) = nodes.row(surface(t, k)).transpose();
  return corners;
}

Eigen::Vector3d normal_of(const Eigen::Matrix3d& corners) {
  return (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
}

SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x) {
  const Vector wanted(x[0], x[1], x[2]);
  SurfacePoint nearest;
  nearest.distance = std::numeric_limits<double>::infinity();
  for (Eigen::Index t = 0; t < surface.rows(); ++t) {
    const auto corners = corners_of(nodes, surface, t);
    const Vector weights = nearest_in_triangle(corners, wanted), point = corners * weights;
    const double distance = (point - wanted).norm();
    if (!(distance < nearest.distance)) continue;
    nearest.distance = distance;
    for (int k = 0; k < 3; ++k) {
      nearest.nodes[static_cast<std::size_t>(k)] = surface(t, k);
      nearest.weights[static_cast<std::size_t>(k)] = weights[k];
      nearest.point[static_cast<std::size_t>(k)] = point[k];
    }
  }
  return nearest;
}

SurfaceTools::SurfaceTools(const Points& nodes, const Triangles& surface)
    : _nodes(nodes),
      _surface(surface),
      _normals(node_normals(nodes, surface)),
      _neighbors(static_cast<std::size_t>(surface.size())),
      _reached(static_cast<std::size_t>(surface.rows())),
      _is_reached(static_cast<std::size_t>(surface.rows()), 0) {
  std::vector<std::int32_t> last_at(static_cast<std::size_t>(nodes.rows())), before(_neighbors.size());
  schema::find_neighbors(surface.data(), static_cast<std::int32_t>(surface.rows()),
                         static_cast<std::int32_t>(nodes.rows()), last_at.data(), before.data(), _neighbors.data());
}

void SurfaceTools::press(const SurfacePoint& center, double radius, bool quadratic, const TakeIntegrals& take) {
  const schema::ToolSurface surface{_nodes.data(), _normals.data(), _surface.data(), _neighbors.data(),
                                    static_cast<std::int32_t>(_surface.rows())};
  const auto press = [&](auto n_functions) {
    schema::integrate_pressure<n_functions>(surface, {_is_reached.data(), _reached.data()}, center.nodes.data(),
                                            center.weights.data(), radius,
                                            [&](std::int32_t t, const double* integrals) {
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
  double at_fixed = 0;
  const auto is_fixed = [&](std::int32_t node) { return std::binary_search(fixed.begin(), fixed.end(), node); };
  if (radius > 0)
    press(center, radius, false, [&](Eigen::Index t, std::span<const double> integrals) {
      at_fixed += schema::integrals_at_fixed(integrals.data(), [&](int k) { return is_fixed(_surface(t, k)); });
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
    if (!is_fixed(node)) {
      touched.nodes.push_back(node);
      touched.weights.push_back(w);
      sum += w;
    }
  if (!(sum > 0)) throw input_error("all nodes of a tool are fixed", "", "touch a part of the surface that can move");
  if (touched.mean)
    for (auto& w : touched.weights) w /= schema::weight_divisor(sum, at_fixed);
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
