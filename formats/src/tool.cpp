#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/formats/tool.hpp>

namespace phynness {

namespace {

bool is_in(std::span<const std::int32_t> ascending, std::int32_t node) {
  return std::binary_search(ascending.begin(), ascending.end(), node);
}

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

namespace {

/// Triangles around the middle of a tool that are connected over edges within the radius.
std::vector<Eigen::Index> touched_triangles(const Points& nodes, const Triangles& surface, const SurfacePoint& center,
                                            const Vector& middle, double radius) {
  std::vector<Eigen::Index> near, reached;
  std::vector<char> taken;
  for (Eigen::Index t = 0; t < surface.rows(); ++t) {
    const auto corners = corners_of(nodes, surface, t);
    const bool within = (corners * nearest_in_triangle(corners, middle) - middle).norm() < radius;
    int shared = 0, wanted = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (center.weights[k] > 0) {
        ++wanted;
        for (int l = 0; l < 3; ++l) shared += surface(t, l) == center.nodes[k];
      }
    if (shared == wanted)
      reached.push_back(t);
    else if (within)
      near.push_back(t);
  }
  taken.assign(near.size(), 0);
  for (std::size_t at = 0; at < reached.size(); ++at) {
    const auto corners = corners_of(nodes, surface, reached[at]);
    for (std::size_t n = 0; n < near.size(); ++n)
      for (int k = 0; k < 3 && !taken[n]; ++k) {
        const int l = (k + 1) % 3;
        const auto a = surface(reached[at], k), b = surface(reached[at], l);
        int shared = 0;
        for (int m = 0; m < 3; ++m) shared += surface(near[n], m) == a || surface(near[n], m) == b;
        if (shared < 2 || !((corners * on_edge(corners, k, l, middle) - middle).norm() < radius)) continue;
        taken[n] = 1;
        reached.push_back(near[n]);
      }
  }
  return reached;
}

/// The integral over the part of a triangle that has the columns of `part` as barycentric coordinates of its corners.
void integrate_part(const Eigen::Matrix3d& corners, const Eigen::Matrix3d& part, const Vector& middle, double radius,
                    const std::function<void(const Vector&, double)>& take) {
  // Lengths in radii. They are no simple fractions, so that on regular meshes rounding decides nothing.
  constexpr double small = 0.0623, small_at_rim = 0.00391, inside = 0.9973;
  const Eigen::Matrix3d x = (corners * part).colwise() - middle;
  const double longest = std::sqrt(std::max(
      {(x.col(1) - x.col(0)).squaredNorm(), (x.col(2) - x.col(1)).squaredNorm(), (x.col(0) - x.col(2)).squaredNorm()}));
  const double nearest = x.rowwise().mean().norm() - longest, farthest = x.colwise().norm().maxCoeff();
  if (nearest >= radius) return;
  if (longest > (farthest < inside * radius ? small : small_at_rim) * radius) {
    Eigen::Matrix3d middles;
    for (int k = 0; k < 3; ++k) middles.col(k) = (part.col((k + 1) % 3) + part.col((k + 2) % 3)) / 2;
    integrate_part(corners, middles, middle, radius, take);
    for (int k = 0; k < 3; ++k) {
      Eigen::Matrix3d corner = middles;
      corner.col(k) = part.col(k);
      integrate_part(corners, corner, middle, radius, take);
    }
    return;
  }
  const double third_of_area = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).norm() / 6;
  for (int k = 0; k < 3; ++k) {
    const Vector at = (part.col((k + 1) % 3) + part.col((k + 2) % 3)) / 2;
    const double pressure = tool_pressure((corners * at - middle).squaredNorm() / (radius * radius));
    if (pressure > 0) take(at, pressure * third_of_area);
  }
}

/// The rigid patch of databases before the mean: the nodes within the radius that are connected over triangles, with
/// u_i = (1 - s^2)^2 d.
TouchedNodes rigid_patch(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                         std::int32_t node, double radius) {
  const auto weight = [&](std::int32_t i) {
    const double s2 = (nodes.row(i) - nodes.row(node)).squaredNorm() / (radius * radius);
    return s2 < 1 - 1e-9 ? (1 - s2) * (1 - s2) : 0.0;
  };
  std::vector<char> reached(static_cast<std::size_t>(nodes.rows()), 0);
  reached[static_cast<std::size_t>(node)] = 1;
  for (bool grows = true; grows;) {
    grows = false;
    for (Eigen::Index t = 0; t < surface.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        const auto of = [&](int c) -> char& { return reached[static_cast<std::size_t>(surface(t, c))]; };
        if (of(k) || !(of((k + 1) % 3) || of((k + 2) % 3)) || !(weight(surface(t, k)) > 0)) continue;
        of(k) = 1;
        grows = true;
      }
  }
  TouchedNodes touched;
  for (std::int32_t i = 0; i < nodes.rows(); ++i) {
    if (!reached[static_cast<std::size_t>(i)] || (i != node && is_in(fixed, i))) continue;
    touched.nodes.push_back(i);
    touched.weights.push_back(i == node ? 1.0 : weight(i));
  }
  return touched;
}

}  // namespace

// A point of the rim, up to rounding, is outside.
double tool_pressure(double s2) { return s2 < 1 - 1e-9 ? 1 : 0; }

void integrate_pressure(const Points& nodes, const Triangles& surface, const SurfacePoint& center, double radius,
                        bool whole, const TakePressure& take) {
  // The normal between nodes is the mean of theirs, so that it turns steadily over edges of the body.
  const Points normals = node_normals(nodes, surface);
  Vector middle = Vector::Zero(), normal = Vector::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (center.weights[k] > 0) {
      middle += center.weights[k] * nodes.row(center.nodes[k]).transpose();
      normal += center.weights[k] * normals.row(center.nodes[k]).transpose();
    }
  normal.normalize();
  for (const auto t : touched_triangles(nodes, surface, center, middle, radius)) {
    const Eigen::Matrix3d corners = corners_of(nodes, surface, t);
    const double facing = whole ? 1 : normal.dot(normal_of(corners).normalized());
    if (facing > 0)
      integrate_part(corners, Eigen::Matrix3d::Identity(), middle, radius,
                     [&](const Vector& at, double part) { take(t, at, facing * part); });
  }
}

SurfacePoint at_node(std::int32_t node) { return {{node, -1, -1}, {1, 0, 0}}; }

TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           const SurfacePoint& center, double radius, bool whole) {
  std::map<std::int32_t, double> weight;
  if (radius > 0)
    integrate_pressure(nodes, surface, center, radius, whole, [&](Eigen::Index t, const Vector& at, double part) {
      for (int k = 0; k < 3; ++k) weight[surface(t, k)] += at[k] * part;
    });
  else
    for (std::size_t k = 0; k < 3; ++k)
      if (center.weights[k] > 0) weight[center.nodes[k]] += center.weights[k];
  TouchedNodes touched;
  touched.mean = radius > 0;
  double sum = 0;
  for (const auto& [node, w] : weight)
    if (!is_in(fixed, node)) {
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
                           std::int32_t node, const ProbeSpec& probe) {
  if (probe.kind == ProbeKind::rigid_patch) return rigid_patch(nodes, surface, fixed, node, probe.tool_radius_m);
  return touched_nodes(nodes, surface, fixed, at_node(node), probe.kind == ProbeKind::patch ? probe.tool_radius_m : 0,
                       probe.whole);
}

bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed) {
  std::vector<char> held(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const auto node : fixed) held[static_cast<std::size_t>(node)] = 1;
  const auto is_held = [&](Eigen::Index c, int k) { return held[static_cast<std::size_t>(mesh.cells(c, k))]; };
  for (Eigen::Index c = 0; mesh.cells.cols() == 3 && c < mesh.cells.rows(); ++c)
    if (is_held(c, 0) + is_held(c, 1) + is_held(c, 2) > 1) return true;
  if (fixed.size() < 3) return false;
  Points at = mesh.nodes(fixed, Eigen::all);
  at.rowwise() -= Eigen::RowVector3d(at.colwise().mean());
  // Eigenvalues: mean square distances from the best plane, within this plane from the best line, and along this line.
  const Eigen::Matrix3d spread = at.transpose() * at / static_cast<double>(fixed.size());
  const auto squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const Eigen::RowVector3d extent = mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff();
  return squares[1] > 1e-12 * extent.squaredNorm();
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

}  // namespace phynness
