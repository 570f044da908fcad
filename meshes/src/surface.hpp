// A closed surface on its way to being filled with tetrahedra.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <string>
#include <vector>

#include "raw_mesh.hpp"

namespace phynness::meshes {

struct Surface {
  Points nodes;  ///< [m]
  Triangles triangles;
};

/// Volume enclosed by a closed surface, positive if its normals point outward (divergence theorem) [m^3].
double enclosed_volume(const Points& nodes, const Triangles& triangles);
double area(const Points& nodes, const Triangles& triangles);
double mean_edge(const Points& nodes, const Triangles& triangles);

/// Scales and checks the triangles of a file: finite, closed, manifold, one component, normals outward.
/// Turning normals and dropping unused nodes is always done; keeping the largest of several components and
/// dropping repeated triangles only with `repair`. Everything done is named in `notes`.
/// @throws Error that counts every defect
Surface checked_surface(const RawMesh& raw, double scale_to_m, bool repair, const std::string& source,
                        std::vector<std::string>& notes);

}  // namespace phynness::meshes
