// Nodes that lie on one another, and bodies of an unlikely size: what looks wrong only in coordinates.
#pragma once

#include <phynness/meshes/meshes.hpp>
#include <vector>

namespace phynness::meshes {

/// For each node the first node at the same place (itself if alone), to a billionth of the bounding box.
std::vector<std::int32_t> coincident_nodes(const Points& nodes);

/// The nodes whose first one is another.
std::vector<std::int32_t> repeated(const std::vector<std::int32_t>& first);

/// Warns of a body that is larger than 10 m or smaller than 0.1 mm: its file may be in other units.
void warn_of_size(MeshResult& result, double scale_to_m);

}  // namespace phynness::meshes
