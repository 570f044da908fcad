// What imported responses must satisfy (formats/imported.md), and the groups of their rows.
#pragma once

#include <phynness/formats/imported.hpp>
#include <phynness/formats/printable.hpp>

namespace phynness::imported {

/// A number with four digits, for messages.
inline std::string brief(double value) { return number_text(value, std::chars_format::general, 4); }

/// Rows of an active node with the same displacement; most have one row.
struct State {
  Eigen::Vector3d displacement_m, force_N;
  double energy_J = 0;
  std::vector<std::int64_t> rows;
};
struct NodeStates {
  std::int32_t node = 0;
  std::vector<State> states;  ///< without those at rest, by displacement
};

/// Completes `touched` to one node of each row, and orients the cells.
/// @throws Error (input) for wrong shapes, nodes, sizes of the body, and numbers that are not finite
void check_shapes(GivenResponses& given, ImportReport& report);

/// Groups the rows. @pre check_shapes()
/// @throws Error (input) for reactions, forces at rest, contradictory repetitions, too few displacements, other units,
/// energies that are not those of the forces, and work that depends on the path
std::vector<NodeStates> checked_states(const GivenResponses& given, ImportReport& report);

/// Reads all output displacements once.
/// @param see  receives them for a hash
/// @throws Error (input) if one is not finite or not that of the tool, or if a fixed node moves
void check_output(const GivenResponses& given, const std::function<void(const std::vector<double>&)>& see);

/// As ImportReport; 0 if the data do not tell.
double path_dependence(const std::vector<NodeStates>& nodes);

}  // namespace phynness::imported
