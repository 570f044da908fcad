// Rotation of the surface around its points.
#pragma once

#include "core/model.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// Vertices with maps: the sum of map times displacement is a rotation vector times an area.
struct SurfaceRotation {
  static constexpr std::int32_t most = 48;
  std::int32_t n;
  std::int32_t vertex[most];  ///< as in phn_model::triangles
  Matrix map[most];           ///< [rad m]
  double area;                ///< [m^2]
};

/// The (infinitesimal) rotation of the surface around some of its vertices, as a sum that must be divided by the area.
/// It is the mean over triangles, weighted by area and by the weights of their vertices. A triangle's rotation is the
/// rotation of its normal plus half the curl in its plane. Rigid rotations are reproduced exactly; stretches along the
/// surface do not contribute. Triangles beyond the first with SurfaceRotation::most vertices do not count.
/// @param vertex, weight  n_vertices; weights >= 0
void find_rotation(const phn_model& model, std::int32_t n_vertices, const std::int32_t* vertex, const double* weight,
                   SurfaceRotation& rotation);

/// The rotation R by the angle 2 atan |v| around v: `rotated` gives R x, `rotated_back` gives R^T x.
Vector rotated(const Vector& v, const Vector& x);
Vector rotated_back(const Vector& v, const Vector& x);

/// Gradient of g . R^T x with respect to v.
Vector rotation_gradient(const Vector& v, const Vector& g, const Vector& x);

}  // namespace PHN_RUNTIME
