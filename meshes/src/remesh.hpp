// A closed surface with triangles of a given size.
#pragma once

#include "surface.hpp"

namespace phynness::meshes {

/// Isotropic remeshing: rounds of splitting long edges, collapsing short ones, flipping towards six edges a
/// node and moving nodes tangentially, always back onto the original surface (Botsch & Kobbelt 2004,
/// doi 10.1145/1057432.1057457). Edges that are sharper than 50 degrees are kept as lines of the new surface
/// and their meeting points as nodes, except where they are finer than the edge length and would leave flat triangles
/// or nearly closed folds (surface_slivers.hpp). Deterministic; the topology (closed, manifold, one component, genus)
/// is that of the input.
/// @pre surface is a closed oriented manifold
Surface remeshed(const Surface& surface, double edge_m);

}  // namespace phynness::meshes
