// The surface that tools touch: what of it can be touched, offsets by the radius of a tool, neighbours, walking on it.
#pragma once

#include <cmath>

#include "arena.hpp"
#include "triangle.hpp"

namespace PHN_RUNTIME {

/// Corners that move have at least this part of a touched point: the stiffness of a point beside a fixed edge has no
/// bound.
inline constexpr double least_movable = 0.05;
/// Longest mitre of an offset: corners of a right-angled box need sqrt(3).
inline constexpr double longest_offset = 2;
inline constexpr double largest_coordinate_m = 1e30;
inline constexpr double largest_distance = 1e3;  ///< of tools and displacements, in sizes of the body

struct ContactSurface {
  std::int32_t n_vertices, n_triangles;
  double size, middle[3];  ///< of the box around all vertices; its diagonal [m]
  std::int32_t* triangle;  ///< n_triangles x 3 vertices: those that can be touched
  std::int32_t* neighbor;  ///< n_triangles x 3: behind the edge opposite to the corner; -1: none
  std::int32_t* node;      ///< n_vertices: in the mesh
  std::int32_t* active;    ///< n_vertices: position among the active nodes, or -1: fixed or unused
  double *rest, *placed;   ///< n_vertices x 3: at rest and displaced by the last field [m]
  double* offset;          ///< n_vertices x 3: way of the vertex per radius of the tool
};

/// A point of the surface: barycentric, >= 0, sum 1.
struct SurfacePoint {
  std::int32_t triangle;
  double weight[3];
};

/// Triangles of the model that can be touched.
std::int32_t count_touchable(const phn_model& model);
/// @param edges  scratch, 3 n_triangles entries of lay_out_contact_surface
struct TouchableEdge {
  std::int32_t low, high, at;  ///< at = 3 triangle + opposite corner
};
ContactSurface lay_out_contact_surface(Arena& arena, const phn_model& model, std::int32_t n_triangles);
/// @return a status of phynness.h
int build_contact_surface(const phn_model& model, TouchableEdge* scratch, ContactSurface& surface);

/// placed = rest + field, cut; null: rest. @return how far the vertex moved that moved most [m]
double place(const phn_model& model, const double* field, ContactSurface& surface);

/// sum_i w_i (points_i + radius offset_i)
void point_at(const ContactSurface& surface, const double* points, const SurfacePoint& at, double radius, double* x);
/// Unit. Interpolated offsets, or that of the triangle where these cancel.
void normal_at(const ContactSurface& surface, const SurfacePoint& at, double* normal);

/// How offset and normal change along the triangle: d(offset) = offset_gradient dx, d(normal) = normal_gradient dx for
/// dx in its plane. @param axes  two unit vectors in that plane
void gradients_at(const ContactSurface& surface, const SurfacePoint& at, double* axes, double* offset_gradient,
                  double* normal_gradient);

/// Moves by `step` [m] in the plane of the triangle, straight on over edges; along the rim where the surface ends.
void walk(const ContactSurface& surface, SurfacePoint& at, const double* step);

/// Part of the corners that move.
double movable(const ContactSurface& surface, const SurfacePoint& at);

inline const double* row(const double* rows, std::int32_t i) { return rows + 3 * static_cast<std::size_t>(i); }
inline double* row(double* rows, std::int32_t i) { return rows + 3 * static_cast<std::size_t>(i); }

/// @param points  placed or rest
inline void corners_of(const ContactSurface& s, const double* points, std::int32_t triangle, const double* corner[3]) {
  for (int k = 0; k < 3; ++k) corner[k] = row(points, s.triangle[3 * triangle + k]);
}

}  // namespace PHN_RUNTIME
