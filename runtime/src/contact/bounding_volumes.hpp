// A binary tree of bounding boxes of the triangles of a contact surface, in one array in depth-first order. A box
// bounds the vertices and separately their offsets, so that one tree serves spheres of every radius.
#pragma once

#include "contact/touchable.hpp"

namespace PHN_RUNTIME {

struct BoundingVolume {
  double low[3], high[3], offset_low[3], offset_high[3];
  std::int32_t right;         ///< the left child follows its parent; -1: a leaf
  std::int32_t first, count;  ///< of a leaf: its range in `order`
};

struct BoundingVolumes {
  std::int32_t n_volumes;
  BoundingVolume* volume;
  std::int32_t* order;  ///< triangles, leaf by leaf
};

BoundingVolumes lay_out_volumes(Arena& arena, std::int32_t n_triangles);
/// Splits at the median of the longest axis.
void build_volumes(const ContactSurface& surface, BoundingVolumes& volumes);
/// Fits the boxes to the present positions of the vertices, from the leaves upwards.
void refit_volumes(const ContactSurface& surface, BoundingVolumes& volumes);

/// First crossing, from outside to inside, of the line segment between two points with the offset surface. A start less
/// than `slack` inside counts as outside. Beside fixed edges the surface cannot be crossed.
/// @return position on the segment, 0 ... 1; -1: no crossing
double sweep(const ContactSurface& surface, const BoundingVolumes& volumes, double radius, const double* from,
             const double* to, double slack, SurfacePoint& point);

/// The nearest point of the offset surface. @return its distance [m]
double nearest(const ContactSurface& surface, const BoundingVolumes& volumes, double radius, const double* x,
               SurfacePoint& point);

}  // namespace PHN_RUNTIME
