// Edge lengths: what a size costs, and the size that gives a wanted number of nodes.
#pragma once

#include <functional>
#include <phynness/meshes/meshes.hpp>
#include <string>

namespace phynness::meshes {

struct Extent {
  double volume_m3 = 0, area_m2 = 0;
};

/// Nodes that a mesh of this edge length is going to have, within some tens of percent.
double expected_nodes(const Extent& extent, double edge_m);

/// @throws Error if a mesh of this edge length would be too big to be meant
void require_affordable(const Extent& extent, double edge_m, const std::string& place);

/// Meshes a few times (secant on the logarithms of size and number) and returns the mesh whose number of
/// nodes is nearest to the target; a note says how near. Deterministic if `mesh_at` is.
/// @throws Error as `mesh_at` does, if no size worked
MeshResult meet_node_target(int target, const Extent& extent, const std::string& place,
                            const std::function<MeshResult(double edge_m)>& mesh_at);

}  // namespace phynness::meshes
