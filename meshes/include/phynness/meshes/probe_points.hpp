// The points of a surface that are probed: nodes that are spread evenly over it, and the coordinates of the other nodes
// between them (docs/theory.md, points between probes).
#pragma once

#include <cstdint>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>
#include <vector>

namespace phynness {

struct Model;

/// In spacings: two probed nodes are never nearer than this, on the border of the part two thirds of it, and no node of
/// the part is farther from the nearest one. The edges between neighbours then have the spacing in the mean.
inline constexpr double least_apart_of_probes = 0.75;

/// spacing = "auto", in radii of the tool: with larger spacings the error between nodes grows faster
/// (docs/decisions/between-points.md).
inline constexpr double auto_spacing_of_radius = 1.0 / 3;

/// Nodes that are spread evenly over a part of the surface, by distances along it. The farthest node is added again and
/// again (Gonzalez 1985, doi 10.1016/0304-3975(85)90224-5); equal arguments give equal nodes.
/// @param nodes, surface  of the mesh [m]
/// @param within     the part, ascending, nodes of the surface
/// @param spacing_m  distance between neighbours; 0: `count` is given
/// @param count      number of nodes, at most that of `within`; 0: the spacing is given
/// @param kept       nodes of the part that are chosen in any case
/// @return ascending
NodeList spread_nodes(const Points& nodes, const Triangles& surface, const NodeList& within, double spacing_m,
                      std::size_t count, const NodeList& kept = {});

/// Coordinates of surface nodes between probed nodes. The triangles are dual to the cells of the nodes that are nearest
/// to each probed node along the surface.
struct ProbeCoordinates {
  Triangles triangles;                 ///< n_triangles x 3 probed nodes, oriented as the surface
  NodeList covered;                    ///< the nodes that have coordinates, ascending, with the probed ones
  std::vector<std::int32_t> triangle;  ///< of each covered node, a row of `triangles`
  Points weights;                      ///< n_covered x 3 barycentric weights in it, >= 0 and of sum 1
  std::vector<char> is_beyond;  ///< of each covered node: beyond the outermost triangles, or it faces another way
  NodeList too_long;            ///< a corner of each triangle that is left out because of its edges
  NodeList unlike;              ///< ascending; without coordinates because of sharp edges or folds
};
/// Only nodes in triangles with edges of at most the tool's radius are covered, and beside the outermost ones nodes up
/// to a quarter of an edge beyond. Triangles end at the probed part: nodes between three cells are no farther from the
/// probed nodes of these than neighbouring probed nodes are from each other, and triangles face as the surface does.
/// A node has none where its tool has little in common with those at the probed nodes, as over sharp edges, nor in a
/// fold, where its stiffness differs from theirs.
/// @param probed, fixed  ascending; nothing reaches across fixed nodes, which have no coordinates
/// @param linear  ascending, other points (NodeSets::linear), to which the probed nodes are joined. The triangles of
///   probed nodes come first and are those without them, and so are the coordinates of the nodes in them; all others
///   follow, with edges of any length, and cover all nodes near them.
ProbeCoordinates probe_coordinates(const Points& nodes, const Triangles& surface, const NodeList& probed,
                                   const NodeList& fixed, double radius_m, const NodeList& linear = {});

/// Sets the coordinates of a model's surface nodes between its active nodes, which are the middles of round tools. If
/// it has linear points, all other free nodes are between these, too. Nodes that are beyond triangles of active nodes
/// alone have the coordinates of the nearest linear point, whose triangle is three times this point.
/// @param radius_m  of the tool
/// @param spread    the active nodes have coordinates between them; if not, they are all nodes of a part
void cover_surface(Model& model, const Mesh& mesh, double radius_m, bool spread = true);

/// A model of no responses, with these coordinates.
Model touched_surface(const Mesh& mesh, const NodeSets& sets, double radius_m);

/// Free nodes of the surface without coordinates, or with those of the nearest linear point.
NodeList without_coordinates(const Mesh& mesh, const NodeSets& sets, double radius_m);

/// Shares of the area that can move where active nodes alone answer a tool, and where linear points have a part. Round
/// tools in triangles of fixed and active nodes have a warning and are in neither.
struct TouchedArea {
  double nonlinear = 0, linear = 0;
};
TouchedArea touched_area(const Model& model, const Mesh& mesh);

/// Where a reduced body answers without a warning, ascending: active nodes, and of round tools those within the radius
/// of one on its side of the body. @param tool_radius_m  0: of node probes
NodeList touchable_nodes(const Mesh& mesh, const NodeSets& sets, double tool_radius_m);

/// How far apart probed nodes are, and how much of the surface they answer for.
struct ProbeSpread {
  double median_m = 0, largest_m = 0;  ///< distance of a node from its nearest neighbour along the surface
  double covered = 0;                  ///< share of the area of the triangles that can move, between covered nodes
};
/// @param covered  ascending
ProbeSpread probe_spread(const Points& nodes, const Triangles& surface, const NodeList& probed, const NodeList& fixed,
                         const NodeList& covered);

}  // namespace phynness
