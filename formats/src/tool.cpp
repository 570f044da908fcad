#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/tool.hpp>

namespace phynness {

namespace {

/// Nodes within the radius around `center` that can be reached from `seeds` over triangles.
std::vector<char> reached_nodes(const Points& nodes, const Triangles& surface, const std::vector<std::int32_t>& seeds,
                                const std::function<double(std::int32_t)>& weight) {
  // Flood fill over triangles. The number of passes is the width of the patch in triangles, which is small.
  std::vector<char> reached(static_cast<std::size_t>(nodes.rows()), 0);
  for (const auto node : seeds) reached[static_cast<std::size_t>(node)] = 1;
  for (bool grows = !seeds.empty(); grows;) {
    grows = false;
    for (Eigen::Index t = 0; t < surface.rows(); ++t) {
      const auto is_reached = [&](int k) { return reached[static_cast<std::size_t>(surface(t, k))] != 0; };
      if (!is_reached(0) && !is_reached(1) && !is_reached(2)) continue;
      for (int k = 0; k < 3; ++k)
        if (!is_reached(k) && weight(surface(t, k)) > 0) {
          reached[static_cast<std::size_t>(surface(t, k))] = 1;
          grows = true;
        }
    }
  }
  return reached;
}

bool is_in(std::span<const std::int32_t> ascending, std::int32_t node) {
  return std::binary_search(ascending.begin(), ascending.end(), node);
}

}  // namespace

TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           std::int32_t node, double tool_radius) {
  if (!(tool_radius > 0)) return {{node}, {1.0}};
  const auto weight = [&](std::int32_t i) {
    return patch_weight((nodes.row(i) - nodes.row(node)).squaredNorm() / (tool_radius * tool_radius));
  };
  const auto reached = reached_nodes(nodes, surface, {node}, weight);
  TouchedNodes touched;
  for (std::int32_t i = 0; i < nodes.rows(); ++i) {
    if (!reached[static_cast<std::size_t>(i)]) continue;
    if (i != node && is_in(fixed, i)) continue;
    touched.nodes.push_back(i);
    touched.weights.push_back(i == node ? 1.0 : weight(i));
  }
  return touched;
}

TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           const SurfacePoint& center, double tool_radius) {
  Eigen::RowVector3d point = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (center.weights[k] > 0) point += center.weights[k] * nodes.row(center.nodes[k]);
  const auto weight = [&](std::int32_t i) {
    return patch_weight((nodes.row(i) - point).squaredNorm() / (tool_radius * tool_radius));
  };
  std::vector<std::int32_t> seeds;
  double at_point = 0, nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(center.weights[k] > 0)) continue;
    const auto corner = center.nodes[k];
    if (weight(corner) > 0) seeds.push_back(corner);
    if (is_in(fixed, corner)) continue;
    at_point += center.weights[k] * weight(corner);
    nearest = std::min(nearest, (nodes.row(corner) - point).norm());
  }
  if (!std::isfinite(nearest))
    throw input_error("all corners of the touched triangle are fixed", "", "touch a part of the surface that can move");
  if (!(at_point > 0))
    throw input_error("a patch between nodes holds no node of its triangle",
                      "its radius is " + std::to_string(tool_radius / nearest) + " of the distance to the nearest one",
                      "use a larger tool_radius_m or smaller elements, or touch a node");
  const auto reached = reached_nodes(nodes, surface, seeds, weight);
  TouchedNodes touched;
  touched.scale = 1 / at_point;
  for (std::int32_t i = 0; i < nodes.rows(); ++i) {
    if (!reached[static_cast<std::size_t>(i)] || is_in(fixed, i)) continue;
    touched.nodes.push_back(i);
    touched.weights.push_back(touched.scale * weight(i));
  }
  return touched;
}

void require_apart(std::span<const SurfacePoint> tools, std::span<const std::int32_t> fixed,
                   const std::function<std::vector<std::int32_t>(std::int32_t node)>& moved_by) {
  const auto corners = [&](const SurfacePoint& tool) {
    std::vector<std::int32_t> free;
    for (std::size_t k = 0; k < 3; ++k)
      if (tool.weights[k] > 0 && !is_in(fixed, tool.nodes[k])) free.push_back(tool.nodes[k]);
    return free;
  };
  for (std::size_t t = 0; t < tools.size() && tools.size() > 1; ++t)
    for (const auto from : corners(tools[t])) {
      const auto moved = moved_by(from);
      for (std::size_t other = 0; other < tools.size(); ++other)
        for (const auto node : other == t ? std::vector<std::int32_t>{} : corners(tools[other]))
          if (is_in(moved, node))
            throw input_error(from == node ? "two tools hold the same node"
                                           : "two tools overlap: one moves a node that the other touches",
                              from == node ? "node " + std::to_string(node)
                                           : "nodes " + std::to_string(from) + " and " + std::to_string(node),
                              "keep tools at least a tool radius apart");
    }
}

bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed) {
  std::vector<char> held(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const auto node : fixed) held[static_cast<std::size_t>(node)] = 1;
  const auto is_held = [&](Eigen::Index c, int k) { return held[static_cast<std::size_t>(mesh.cells(c, k))]; };
  for (Eigen::Index c = 0; mesh.cells.cols() == 3 && c < mesh.cells.rows(); ++c)
    if (is_held(c, 0) + is_held(c, 1) + is_held(c, 2) > 1) return true;
  if (fixed.size() < 3) return false;
  const Points& nodes = mesh.nodes;
  Points at(static_cast<Eigen::Index>(fixed.size()), 3);
  for (std::size_t i = 0; i < fixed.size(); ++i) at.row(static_cast<Eigen::Index>(i)) = nodes.row(fixed[i]);
  at.rowwise() -= Eigen::RowVector3d(at.colwise().mean());
  // Eigenvalues: mean square distances from the best plane, within this plane from the best line, and along this line.
  const Eigen::Matrix3d spread = at.transpose() * at / static_cast<double>(fixed.size());
  const auto squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const Eigen::RowVector3d extent = nodes.colwise().maxCoeff() - nodes.colwise().minCoeff();
  return squares[1] > 1e-12 * extent.squaredNorm();
}

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

Vector on_triangle(const Eigen::Matrix3d& corners, const Vector& x) {
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

}  // namespace

SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x) {
  const Vector wanted(x[0], x[1], x[2]);
  SurfacePoint nearest;
  nearest.distance = std::numeric_limits<double>::infinity();
  for (Eigen::Index t = 0; t < surface.rows(); ++t) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = nodes.row(surface(t, k)).transpose();
    const Vector weights = on_triangle(corners, wanted), point = corners * weights;
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

}  // namespace phynness
