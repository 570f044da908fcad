// Flat tetrahedra that gmsh leaves: at the surface and between close faces of it.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Removes cells of quality below `sliver_quality` that lie on the surface with two faces, which swaps the diagonal of
/// a nearly plane quadrilateral of the surface, or with three faces, which removes a flat tip. Cells are kept if their
/// removal would make the surface non-manifold or result in flat triangles.
/// @return number of removed cells
std::int32_t peel_slivers(RawMesh& raw);

/// Adds a node in an inner edge of each flat cell, at the position with the best shape of the worst surrounding cell.
/// The surface and the numbers of all nodes do not change; new nodes are the last ones. As in checked_body cells may
/// have any orientation.
/// @return number of new nodes
std::int32_t split_slivers(RawMesh& raw);

}  // namespace phynness::meshes
