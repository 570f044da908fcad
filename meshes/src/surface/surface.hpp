// Closed surfaces that are to be filled with tetrahedra: checks, crossings, triangles of a given size.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <string>
#include <vector>

#include "read/raw_mesh.hpp"
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

/// Pairs of intersecting triangles, smaller number first, sorted. Triangles that only share a node or an edge do not
/// count unless they also intersect elsewhere.
std::vector<std::array<std::int32_t, 2>> crossing_triangles(const Surface& surface);
/// Smooths the surface around its intersections, in growing neighbourhoods, until there are none. `notes` describes the
/// changes. A surface without intersections is not changed.
/// @throws Error (input) with the remaining pairs if smoothing does not help
void untangle(Surface& surface, std::vector<std::string>& notes);

/// Isotropic remeshing (Botsch & Kobbelt 2004, doi 10.1145/1057432.1057457): rounds of splitting long edges, collapsing
/// short edges, flipping edges towards six per node, and tangential smoothing with projection onto the original
/// surface. Edges with angles above 50 degrees remain lines of the new surface, and their meeting points remain nodes,
/// except features that are finer than the edge length and would result in flat triangles or nearly closed folds
/// (surface_slivers.cpp). The result is deterministic; its topology (closed, manifold, one component, genus) is that of
/// the input.
/// @pre surface is a closed oriented manifold
Surface remeshed(const Surface& surface, double edge_m);

/// Of several components keeps that of the largest volume, or area if any is open, with a note.
void keep_largest_surface(RawMesh& raw, SurfaceTopology& topology);

/// Scales and checks the triangles of a file: finite, closed, manifold, one component, normals outward. Triangles are
/// always reoriented and unused nodes always dropped. Only with `repair` the largest of several components is kept and
/// repeated triangles are dropped. `notes` gets those of `raw` and all changes.
/// @throws Error with the number of defects of each kind
Surface checked_surface(RawMesh raw, double scale_to_m, bool repair, const std::string& source,
                        std::vector<std::string>& notes);

}  // namespace phynness::meshes
