// A closed surface that is to be filled with tetrahedra.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <string>
#include <vector>

#include "raw_mesh.hpp"
#include "topology.hpp"

namespace phynness::meshes {

struct Surface {
  Points nodes;  ///< [m]
  Triangles triangles;
};

/// Volume enclosed by a closed surface, positive if its normals point outward (divergence theorem) [m^3].
double enclosed_volume(const Points& nodes, const Triangles& triangles);
double area(const Points& nodes, const Triangles& triangles);
double mean_edge(const Points& nodes, const Triangles& triangles);

/// orient_consistently() with a note. @return false if a component has no consistent orientation
bool orient(Triangles& triangles, const SurfaceTopology& topology, std::vector<std::string>& notes);

/// Scales and checks the triangles of a file: finite, closed, manifold, one component, normals outward. Triangles are
/// always reoriented and unused nodes always dropped. Only with `repair` the largest of several components is kept and
/// repeated triangles are dropped. `notes` lists all changes.
/// @throws Error with the number of defects of each kind
Surface checked_surface(RawMesh raw, double scale_to_m, bool repair, const std::string& source,
                        std::vector<std::string>& notes);

}  // namespace phynness::meshes
