// From a file's or gmsh's triangles to the middle surface of a shell that a solver may trust.
#pragma once

#include <phynness/meshes/meshes.hpp>
#include <string>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Scales, drops unreferenced nodes, makes triangles run the same way, checks finiteness, areas, components and edges.
/// The surface may be open. With `repair`, coincident nodes are merged and the largest of several components is kept.
/// @return cells and surface are the same triangles; notes and warnings; quality filled in
/// @throws Error naming the defect with its count
MeshResult checked_shell(const RawMesh& raw, double scale_to_m, bool repair, const std::string& source);

/// Refuses a wall that is thicker than the surface is long or bends more sharply than it is thick, and warns of one
/// that is thicker than half the radius of a bend.
void check_wall(MeshResult& shell, double thickness_m, const std::string& source);

}  // namespace phynness::meshes
