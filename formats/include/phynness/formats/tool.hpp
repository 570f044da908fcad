// Points of the surface, and a check that the fixed nodes hold the body.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <span>
#include <string>
#include <vector>

namespace phynness {

/// A point of the undeformed surface: a triangle's nodes and barycentric weights, >= 0 and of sum 1.
struct SurfacePoint {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  Vec3 point{};         ///< [m]
  double distance = 0;  ///< from the given point [m]
};
/// The corners of a triangle, one in each column.
Eigen::Matrix3d corners_of(const Points& nodes, const Triangles& surface, Eigen::Index t);
/// Its normal, by the order of the corners, with twice the area as length.
Eigen::Vector3d normal_of(const Eigen::Matrix3d& corners);
/// Barycentric weights of the point of a triangle that is nearest to x. @param corners  as corners_of()
Eigen::Vector3d nearest_in_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& x);
/// The point of the surface nearest to x [m]. @pre surface has triangles
SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x);

SurfacePoint at_node(std::int32_t node);

/// True if the fixed nodes prevent every rigid motion: at least three nodes that are not on one line, or an edge of a
/// shell, which is clamped there. A singular factorization does not detect this reliably, because rounding turns its
/// zero pivots into small numbers.
bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed);

}  // namespace phynness
