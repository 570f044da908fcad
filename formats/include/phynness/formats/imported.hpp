// Responses of other programs or of measurements, as a database. Layout and checks: formats/imported.md.
#pragma once

#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/described.hpp>

namespace phynness {

/// Rows of responses: one place of the body displaced, the force that holds it there, and what else is known.
struct GivenResponses {
  std::string title, source;  ///< source: file name, for messages and `phynness info`
  Points points_m = Points(0, 3);
  Cells cells;                               ///< n x 4 tetrahedra of either orientation, or n x 3 surface triangles
  std::vector<std::int32_t> fixed, touched;  ///< touched: node of each row, or one node of all rows
  double tool_radius_m = 0;                  ///< of a round tool; 0: single nodes
  Points displacements_m = Points(0, 3), forces_N = Points(0, 3);  ///< one row each
  std::vector<double> energies_J;                                  ///< of each row; empty: not known
  std::vector<std::int32_t> output;                                ///< nodes whose displacement is known, in any order
  /// Writes the displacements of the output nodes in a row, output x 3 [m]. It is called several times for each row.
  std::function<void(std::int64_t row, double* displacements_m)> output_displacements;
};

inline constexpr std::int64_t most_imported_rows = 1'000'000;

struct ImportReport {
  std::vector<std::string> notes, warnings;                             ///< sentences
  std::int64_t rows = 0, at_rest = 0, repeated = 0, displacements = 0;  ///< displacements: different ones of all nodes
  double largest_displacement_m = 0, largest_force_N = 0;
  /// Median of energy over force . displacement, 1/2 for linear responses; 0: not known.
  double energy_over_work = 0;
  /// Mean curl of the force over that of a pure rotation of the same stiffness: 0 where work does not depend on the
  /// path, 1 where it depends on nothing else.
  double path_dependence = 0;
  PHYNNESS_FIGURES(notes, warnings, rows, at_rest, repeated, displacements, largest_displacement_m, largest_force_N,
                   energy_over_work, path_dependence)
};

/// Reads a file of responses but for the displacements of output nodes, which are read by rows.
/// @throws Error (input) if an array is missing or has another shape, type or unit, or if there are too many rows
GivenResponses read_responses(const std::filesystem::path& file);

/// Checks all numbers and writes a finished database. Nothing of the size of the output displacements is held in
/// memory.
/// @param progress  called with the written and all response sets
/// @param stop      polled; true ends with a failure, and nothing is written
/// @throws Error (input) for what formats/imported.md lists; (failure) if it cannot be written
ImportReport import_responses(GivenResponses given, const std::filesystem::path& database,
                              const std::function<void(std::int64_t, std::int64_t)>& progress = {},
                              const std::function<bool()>& stop = {});

}  // namespace phynness
