// Flat tetrahedra between faces of a surface that lie close to each other, where no inner node can be moved.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Puts a node into an inner edge of each flat cell, where the worst of the cells around it is best. The surface and
/// the numbers of all nodes stay; new nodes come last. Cells are as in checked_body: their direction does not matter.
/// @return number of new nodes
std::int32_t split_slivers(RawMesh& raw);

}  // namespace phynness::meshes
