// Converts a ray of a database to a grid of all points whose displacement is known.
#pragma once

#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/vtk.hpp>
#include <string>
#include <vector>

namespace phynness::cli {

struct ShownResponse {
  VtkGrid grid;
  /// One per converged increment. The time is the prescribed displacement [m]. Fields: `displacement` [m], `force` [N]
  /// (the total force at the touched node, zero elsewhere), `prescribed` (weight of the tool, 0 to 1), and stored
  /// scalar fields by their column() (0 except at output nodes).
  std::vector<VtkState> states;
  std::vector<int> increments;     ///< increment numbers of the states; the first increment is 1
  std::vector<std::string> notes;  ///< omitted parts, with the reason
};

/// Displacements are known at output nodes (stored), fixed nodes (zero) and nodes held by the tool (prescribed). The
/// cells are all tetrahedra if every node is known, else surface triangles between known nodes, else the known nodes.
/// @param node       mesh node number of an active node
/// @param direction  index of the direction
/// @param increment  1 ... n; empty: all converged increments
/// @throws Error (input) if there is no such ray, or if no requested increment converged
ShownResponse shown_response(const Database& database, std::int32_t node, int direction, std::optional<int> increment);

}  // namespace phynness::cli
