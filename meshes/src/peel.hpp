// Flat tetrahedra on the surface of a generated mesh, which no smoothing of inner nodes can cure.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Removes cells of quality below `sliver_quality` that lie on the surface with exactly two faces: that only
/// swaps the diagonal of a nearly plane quadrilateral of the surface. Left alone where the swap would not
/// keep it manifold.
/// @return number of cells removed
std::int32_t peel_slivers(RawMesh& raw);

}  // namespace phynness::meshes
