// How far the surface around its points turns.
#pragma once

#include "model.hpp"
#include "vectors.hpp"

namespace PHN_RUNTIME {

/// Vertices and maps: the sum of map times displacement is a rotation vector times an area.
struct SurfaceTurn {
  static constexpr std::int32_t most = 48;
  std::int32_t n;
  std::int32_t vertex[most];  ///< as in phn_model::triangles
  Matrix map[most];           ///< [rad m]
  std::int32_t triangle;      ///< where the next part begins
  double area;                ///< of all parts so far [m^2]
};

/// The (infinitesimal) rotation of the surface around up to three of its vertices, in parts whose sum is still to be
/// divided by their area: the mean over triangles, weighted by area and by the weights of the vertices that they meet.
/// A triangle's rotation is what tilts its normal, and half the curl in its plane. Rigid rotations are found, stretches
/// along the surface not felt. All parts together cost a pass over all triangles.
/// @param vertex, weight  n_vertices; weights >= 0
/// @param turn  triangle = 0, area = 0 before the first part; one, unless more than SurfaceTurn::most vertices meet
/// @return false if there is none left
bool next_turn(const phn_model& model, std::int32_t n_vertices, const std::int32_t* vertex, const double* weight,
               SurfaceTurn& turn);

/// Rotation by the angle 2 atan |v| around v: R x, and R^T x.
Vector rotated(const Vector& v, const Vector& x);
Vector rotated_back(const Vector& v, const Vector& x);

/// Gradient of g . R^T x by v.
Vector rotation_gradient(const Vector& v, const Vector& g, const Vector& x);

}  // namespace PHN_RUNTIME
