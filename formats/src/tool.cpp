#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/tool.hpp>

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

SurfacePoint at_node(std::int32_t node) { return {{node, -1, -1}, {1, 0, 0}}; }

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
