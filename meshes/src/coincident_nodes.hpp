// Checks for coincident nodes and for bodies of an unlikely size.
#pragma once

#include <phynness/meshes/meshes.hpp>
#include <vector>

namespace phynness::meshes {

/// For each node the first node at the same position (the node itself if there is no other), with a tolerance of 1e-9
/// of the bounding box.
std::vector<std::int32_t> coincident_nodes(const Points& nodes);

/// The nodes whose first node is another one.
std::vector<std::int32_t> repeated(const std::vector<std::int32_t>& first);

/// Warns of a body that is larger than 10 m or smaller than 0.1 mm: its file may be in other units.
void warn_of_size(MeshResult& result, double scale_to_m);

}  // namespace phynness::meshes
