// Makes a checked mesh from the tetrahedra of a file or of gmsh.
#pragma once

#include <phynness/meshes/meshes.hpp>
#include <string>
#include <vector>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Scales, drops unreferenced nodes, orients cells, and checks finiteness, volumes, overlaps, components and the
/// surface. With `repair`, coincident nodes of separate pieces are merged and only the largest of several components is
/// kept.
/// @return mesh with surface and groups, notes and warnings; quality is set
/// @throws Error naming the defect with its count and the first cells or nodes
MeshResult checked_body(RawMesh raw, double scale_to_m, bool repair, const std::string& source);

}  // namespace phynness::meshes
