// Removes flat tetrahedra on the surface of a generated mesh, which smoothing of inner nodes cannot improve.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Removes cells of quality below `sliver_quality` that lie on the surface with two faces, which only swaps the
/// diagonal of a nearly plane quadrilateral of the surface, or with three, which cuts off a flat tip. Left alone where
/// the surface would not stay manifold, or where flat triangles would come to light.
/// @return number of cells removed
std::int32_t peel_slivers(RawMesh& raw);

}  // namespace phynness::meshes
