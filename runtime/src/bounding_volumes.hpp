// A binary tree of boxes over the triangles of a contact surface, in one array, depth first. A box holds the vertices
// and, apart from them, their offsets, so that one tree serves spheres of every radius.
#pragma once

#include "contact_surface.hpp"

namespace PHN_RUNTIME {

struct BoundingVolume {
  double low[3], high[3], offset_low[3], offset_high[3];
  std::int32_t right;         ///< the left child follows its parent; -1: a leaf
  std::int32_t first, count;  ///< of a leaf: in `order`
};

struct BoundingVolumes {
  std::int32_t n_volumes;
  BoundingVolume* volume;
  std::int32_t* order;  ///< triangles, leaf by leaf
};

BoundingVolumes lay_out_volumes(Arena& arena, std::int32_t n_triangles);
/// Halves at the median of the longest axis.
void build_volumes(const ContactSurface& surface, BoundingVolumes& volumes);
/// Boxes around the vertices where they are placed now, bottom up.
void refit_volumes(const ContactSurface& surface, BoundingVolumes& volumes);

/// First crossing of the straight way between two points with the offset surface, from outside to inside; a start less
/// than `slack` inside counts as outside. Beside fixed edges there is
/// nothing to cross.
/// @return the part of the way, 0 ... 1, or -1: none
double sweep(const ContactSurface& surface, const BoundingVolumes& volumes, double radius, const double* from,
             const double* to, double slack, SurfacePoint& at);

/// The nearest point of the offset surface. @return its distance [m]
double nearest(const ContactSurface& surface, const BoundingVolumes& volumes, double radius, const double* x,
               SurfacePoint& at);

}  // namespace PHN_RUNTIME
