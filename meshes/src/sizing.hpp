// Edge lengths: of meshes of a wanted number of nodes, and those that give too many.
#pragma once

#include <functional>
#include <phynness/meshes/meshes.hpp>
#include <string>

namespace phynness::meshes {

struct Extent {
  double volume_m3 = 0, area_m2 = 0;
};
/// Of a built-in shape from all of its dimensions. @pre it is not the liver
Extent extent_of_shape(const MeshSpec& shape);

/// @throws Error if a mesh of this edge length would be so large that it is probably a mistake
void require_affordable(const Extent& extent, double edge_m, const std::string& place);

/// Makes several meshes (secant method on the logarithms of size and number) and returns the mesh whose number of nodes
/// is nearest to the target; a note states the result. It is deterministic if `mesh_at` is.
/// @throws Error as `mesh_at`, if no size worked
MeshResult meet_node_target(int target, const Extent& extent, const std::string& place,
                            const std::function<MeshResult(double edge_m)>& mesh_at);

}  // namespace phynness::meshes
