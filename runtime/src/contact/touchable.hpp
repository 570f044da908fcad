// The surface that tools touch: its touchable triangles, offsets by the radius of a tool, neighbours, and motion of
// points on it.
#pragma once

#include <cmath>

#include "core/arena.hpp"
#include "tools/triangle.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// Largest length of an offset in radii; the corner of a cuboid needs sqrt(3).
inline constexpr double longest_offset = 2;
inline constexpr double largest_coordinate_m = 1e30;
inline constexpr double largest_distance = 1e3;  ///< of tools and of displacements, in sizes of the body

/// See ContactSurface::active.
inline constexpr std::int32_t several = INT32_MAX;

struct ContactSurface {
  std::int32_t n_vertices, n_triangles;
  std::int32_t n_field;    ///< the first vertices have rows in fields of displacements
  double size, middle[3];  ///< diagonal and centre of the bounding box of all vertices [m]
  std::int32_t* triangle;  ///< n_triangles x 3 vertices, of triangles that can be touched
  std::int32_t* neighbor;  ///< n_triangles x 3: triangle across the edge opposite to the corner; -1: none
  std::int32_t* node;      ///< n_vertices: number in the mesh
  /// n_vertices: the only active node that moves the vertex, or `several`; -1: the vertex is fixed; -2: it is not fixed
  /// but cannot be touched.
  std::int32_t* active;
  double *rest, *placed;  ///< n_vertices x 3: positions undeformed and displaced by the last field [m]
  double* offset;         ///< n_vertices x 3: offset of the vertex per radius of the tool
};

/// A point of the surface with barycentric weights, >= 0 and of sum 1.
struct SurfacePoint {
  std::int32_t triangle;
  double weight[3];
};

/// An edge of a triangle; 3 n_triangles of them are the working memory of build_contact_surface.
struct TouchableEdge {
  std::int32_t low, high, corner;  ///< corner: 3 triangle + the corner opposite to the edge
};
/// @param n_vertices, n_triangles  of the whole surface
ContactSurface lay_out_contact_surface(Arena& arena, std::int32_t n_vertices, std::int32_t n_field,
                                       std::int32_t n_triangles);
/// @param triangles  n x 3 vertices of the whole surface, of which those that can be touched remain
/// @param surface    node, active and rest are set
/// @return a status of phynness.h
int build_contact_surface(const std::int32_t* triangles, std::int32_t n, TouchableEdge* scratch,
                          ContactSurface& surface);

/// placed = rest + field, clamped; null: rest. @param field  n_field x 3. @return largest displacement of a vertex by
/// this call [m]
double place(const double* field, ContactSurface& surface);

/// sum_i w_i (points_i + radius offset_i)
Vector point_at(const ContactSurface& surface, const double* points, const SurfacePoint& point, double radius);
/// Unit normal: the direction of the interpolated offset, or the triangle's normal where the offsets cancel.
Vector normal_at(const ContactSurface& surface, const SurfacePoint& point);

/// Derivatives in a triangle: d(offset) = offset dx, d(normal) = normal dx for dx in its plane.
struct SurfaceGradients {
  Vector axes[2];  ///< two unit vectors in that plane
  Matrix offset, normal;
};
SurfaceGradients gradients_at(const ContactSurface& surface, const SurfacePoint& point);

/// Moves the point by `step` [m] in the plane of the triangle, straight across edges, and along the boundary of an open
/// surface.
void walk(const ContactSurface& surface, SurfacePoint& point, const Vector& step);

/// Sum of the weights of moving corners.
double movable_weight(const ContactSurface& surface, const SurfacePoint& point);

inline const double* row(const double* rows, std::int32_t i) { return rows + 3 * static_cast<std::size_t>(i); }
inline double* row(double* rows, std::int32_t i) { return rows + 3 * static_cast<std::size_t>(i); }

/// @param points  placed or rest
inline void corners_of(const ContactSurface& s, const double* points, std::int32_t triangle, const double* corner[3]) {
  for (int k = 0; k < 3; ++k) corner[k] = row(points, s.triangle[3 * triangle + k]);
}

}  // namespace PHN_RUNTIME
