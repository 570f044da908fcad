// Nodes and cells of a selection on a body.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>
#include <string>

namespace phynness::meshes {

/// Properties of a body that selectors use.
struct SelectableBody {
  /// Initially no node is fixed. @pre the mesh has a node and outlives this object
  explicit SelectableBody(const Mesh& mesh);
  /// Points in cells instead of nodes, for selections of cells: their numbers are those of `points`.
  /// @param in_cell  the cell of each point; all three outlive this object
  SelectableBody(const SelectableBody& nodes, const Points& points, const NodeList& in_cell);

  const Mesh& mesh;
  const Points* points;                      ///< the nodes, or points in cells
  const SelectableBody* of_nodes = nullptr;  ///< with points in cells: the nodes of the body
  const NodeList* in_cell = nullptr;
  NodeList every_node, surface;  ///< sorted
  NodeList fixed;                ///< sorted; set before selectors that depend on it are applied
  NodeList probed;               ///< sorted: points that a database has, which spread points keep
  double tool_radius_m = 0;      ///< of the scene's probe; 0: it displaces a node
  Eigen::RowVector3d low, high;  ///< bounding box [m]
  double slack_m;                ///< a node up to this far outside of a border counts as inside, because of rounding
};

/// Of ascending lists.
NodeList common(const NodeList& a, const NodeList& b);
NodeList without(const NodeList& a, const NodeList& b);

/// For messages.
struct Wanted {
  std::string nodes;  ///< "fixed nodes", "active nodes", "output nodes" or "cells of region 'nodule'"
  std::string place;  ///< "file.toml:12: " or empty
};

/// The selected nodes, sorted and without repeats.
/// @throws Error (input) if a selector selects no node, or if the body does not have a named group or node
NodeList select_nodes(const Selection& selection, const SelectableBody& body, const Wanted& wanted);

/// The nodes of the surface over which a selector spreads its own. @pre its kind is SelectorKind::spread
NodeList nodes_to_spread_over(const Selector& selector, const SelectableBody& body, const Wanted& wanted);

}  // namespace phynness::meshes
