// A closed surface with triangles of a given size.
#pragma once

#include "surface.hpp"

namespace phynness::meshes {

/// Isotropic remeshing (Botsch & Kobbelt 2004, doi 10.1145/1057432.1057457): rounds of splitting long edges, collapsing
/// short edges, flipping edges towards six per node, and tangential smoothing with projection onto the original
/// surface. Edges with angles above 50 degrees remain lines of the new surface, and their meeting points remain nodes,
/// except features that are finer than the edge length and would result in flat triangles or nearly closed folds
/// (surface_slivers.hpp). The result is deterministic; its topology (closed, manifold, one component, genus) is that of
/// the input.
/// @pre surface is a closed oriented manifold
Surface remeshed(const Surface& surface, double edge_m);

}  // namespace phynness::meshes
