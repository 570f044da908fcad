// Flat triangles and thin folds of a remeshed surface, of which no good tetrahedra can be made.
#pragma once

#include "changing_surface.hpp"
#include "closest_point.hpp"

namespace phynness::meshes {

/// Collapses and flips edges at triangles that are nearly flat and at outward folds that are nearly closed, across
/// features that are finer than the edge length. Each change improves the worst shape around it and stays close to the
/// original surface, in distance and in volume. A surface without such shapes stays as it is.
void remove_slivers(ChangingSurface& surface, const ClosestPoint& original, double edge_m);

}  // namespace phynness::meshes
