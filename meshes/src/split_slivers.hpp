// Flat tetrahedra between close faces of a surface, without an inner node that could be moved.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Adds a node in an inner edge of each flat cell, at the position with the best shape of the worst surrounding cell.
/// The surface and the numbers of all nodes do not change; new nodes are the last ones. As in checked_body cells may
/// have any orientation.
/// @return number of new nodes
std::int32_t split_slivers(RawMesh& raw);

}  // namespace phynness::meshes
