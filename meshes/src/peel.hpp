// Removes flat tetrahedra on the surface of a generated mesh, which smoothing of inner nodes cannot improve.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Removes cells of quality below `sliver_quality` that lie on the surface with two faces, which swaps the diagonal of
/// a nearly plane quadrilateral of the surface, or with three faces, which removes a flat tip. Cells are kept if their
/// removal would make the surface non-manifold or result in flat triangles.
/// @return number of removed cells
std::int32_t peel_slivers(RawMesh& raw);

}  // namespace phynness::meshes
