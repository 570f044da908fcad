// From a ray of a database to the part of the body whose displacement is known.
#pragma once

#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/vtk.hpp>
#include <string>
#include <vector>

namespace phynness::cli {

struct ShownResponse {
  VtkGrid grid;
  /// One per increment that converged: time is the prescribed displacement [m]; fields `displacement` [m],
  /// `force` [N] (the whole force, at the touched node; zero elsewhere), `prescribed` (weight of the tool, 0
  /// to 1), and stored scalar fields by their column() (0 at nodes that are no output nodes).
  std::vector<VtkState> states;
  std::vector<int> increments;     ///< numbers of the states, 1 is the first
  std::vector<std::string> notes;  ///< what is not shown, and why
};

/// Displacements are known at output nodes (stored), fixed nodes (zero) and those the tool holds
/// (prescribed). Cells: all tetrahedra if every node is known; else surface triangles between known nodes; if
/// there is none, the known nodes themselves.
/// @param node       mesh node number of an active node
/// @param direction  index into the directions
/// @param increment  1 ... n; none: all that converged
/// @throws Error if there is no such ray, or nothing of it converged
ShownResponse shown_response(const Database& database, std::int32_t node, int direction, std::optional<int> increment);

}  // namespace phynness::cli
