// Removal of flat triangles and thin folds of a remeshed surface, which prevent tetrahedra of good quality.
#pragma once

#include "changing_surface.hpp"
#include "closest_point.hpp"

namespace phynness::meshes {

/// Collapses and flips edges at nearly flat triangles and at nearly closed outward folds, also across features that are
/// finer than the edge length. Each change improves the worst shape around it and is limited in distance and volume. A
/// surface without such shapes is not changed.
void remove_slivers(ChangingSurface& surface, const ClosestPoint& original, double edge_m);

}  // namespace phynness::meshes
