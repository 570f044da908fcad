// Defects of a surface or a body as a complex of triangles or tetrahedra, independent of coordinates.
#pragma once

#include <array>
#include <phynness/formats/mesh.hpp>
#include <string>
#include <vector>

namespace phynness::meshes {

using Edge = std::array<std::int32_t, 2>;  ///< smaller node first
inline Edge edge_of(std::int32_t a, std::int32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }

/// A row of three node numbers for each triangle.
Triangles to_matrix(const std::vector<std::array<std::int32_t, 3>>& list);

struct Components {
  std::vector<std::int32_t> component;       ///< of each element; triangles that share a node, cells that share a face
  std::vector<std::size_t> component_sizes;  ///< elements, by component number
};

struct SurfaceTopology : Components {
  std::vector<Edge> open_edges;             ///< edges of one triangle
  std::vector<Edge> non_manifold_edges;     ///< edges of more than two triangles
  std::vector<std::int32_t> pinched_nodes;  ///< nodes whose triangles form more than one fan
  std::vector<Edge> inconsistent_edges;     ///< both triangles have the same direction along the edge
  bool closed_manifold() const { return open_edges.empty() && non_manifold_edges.empty() && pinched_nodes.empty(); }
};
SurfaceTopology surface_topology(const Triangles& triangles);

/// Reverses triangles so that all triangles of a component are consistent with its first triangle.
/// @pre every edge belongs to at most two triangles
/// @return number of reversed triangles, or -1 if a component has no consistent orientation
std::int32_t orient_consistently(Triangles& triangles, const SurfaceTopology& topology);

struct CellTopology : Components {
  std::vector<std::int32_t> folded_cells;   ///< lie on the same side of a face as their neighbour: they overlap
  std::vector<std::int32_t> crowded_cells;  ///< share a face with more than one other cell
};
/// @pre cells have positive orientation
CellTopology cell_topology(const std::vector<std::array<std::int32_t, 4>>& cells);

/// The defects of the surface in one line, such as "31 open edges (first: 3-17, 17-20), 16 components (...)"; empty if
/// there are none. @param numbers  of the nodes; empty: their positions
std::string describe_defects(const SurfaceTopology& topology, bool with_components,
                             const std::vector<std::int32_t>& numbers = {});

/// The first entries: "12, 15, 18, ...".
std::string first_few(const std::vector<std::int32_t>& numbers, std::size_t how_many = 8);
/// "3 components of 120, 4 and 2 <things>".
std::string describe_components(const std::vector<std::size_t>& sizes, const char* things);
/// "1 edge", "2 edges".
std::string counted(std::size_t n, const char* singular, const char* plural);

}  // namespace phynness::meshes
