// Makes a checked middle surface of a shell from the triangles of a file or of gmsh.
#pragma once

#include <phynness/meshes/meshes.hpp>
#include <string>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Scales, drops unreferenced nodes, orients triangles consistently, and checks finiteness, areas, components and
/// edges. The surface may be open. With `repair`, coincident nodes are merged and only the largest of several
/// components is kept.
/// @return cells and surface are the same triangles; notes and warnings; quality is set
/// @throws Error naming the defect with its count
MeshResult checked_shell(RawMesh raw, double scale_to_m, bool repair, const std::string& source);

/// Refuses a wall that is thicker than the surface is long or than the diameter of a bend, and warns of a wall that is
/// thicker than half the radius of a bend.
void check_wall(MeshResult& shell, double thickness_m, const std::string& source);

}  // namespace phynness::meshes
