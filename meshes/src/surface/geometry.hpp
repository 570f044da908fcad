// Corners, extent and quality of tetrahedra and triangles.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <phynness/formats/mesh.hpp>

namespace phynness::meshes {

template <class Matrix>
std::array<Eigen::RowVector3d, 3> corners_of(const Points& nodes, const Matrix& triangles, Eigen::Index t) {
  return {nodes.row(triangles(t, 0)), nodes.row(triangles(t, 1)), nodes.row(triangles(t, 2))};
}

/// Edges of the bounding box.
inline Eigen::RowVector3d extent_of(const Points& nodes) {
  return nodes.colwise().maxCoeff() - nodes.colwise().minCoeff();
}

/// Radius ratio 3 r_in / r_circ of a tetrahedron with edges u, v, w from one node: 1 regular, 0 flat. r_in =
/// 3 V / A, r_circ = |u^2 (v x w) + v^2 (w x u) + w^2 (u x v)| / (12 V).
inline double radius_ratio(const Eigen::RowVector3d& u, const Eigen::RowVector3d& v, const Eigen::RowVector3d& w) {
  const Eigen::RowVector3d vw = v.cross(w), wu = w.cross(u), uv = u.cross(v);
  const double volume = u.dot(vw) / 6;
  const double total_area = (vw.norm() + wu.norm() + uv.norm() + (v - u).cross(w - u).norm()) / 2;
  const double twelve_v_r = (u.squaredNorm() * vw + v.squaredNorm() * wu + w.squaredNorm() * uv).norm();
  if (!(total_area > 0) || !(twelve_v_r > 0)) return 0;
  return 108 * volume * volume / (total_area * twelve_v_r);
}

/// 2 r_in / r_circ of a triangle with edges u, v from one node; r_in = 2 A / (a + b + c), r_circ = a b c / (4 A).
inline double radius_ratio(const Eigen::RowVector3d& u, const Eigen::RowVector3d& v) {
  const double a = u.norm(), b = v.norm(), c = (v - u).norm(), twice_area = u.cross(v).norm();
  return a * b * c > 0 ? 4 * twice_area * twice_area / ((a + b + c) * a * b * c) : 0;
}

}  // namespace phynness::meshes
