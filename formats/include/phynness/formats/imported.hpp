// Responses of other programs, as a database. Layout and checks: formats/imported.md.
#pragma once

#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/described.hpp>

namespace phynness {

struct ImportReport {
  std::int64_t rays = 0, missing_rays = 0;  ///< missing: all their forces are NaN
  double largest_displacement_m = 0, largest_force_N = 0;
  /// Median of energy over force . displacement, 1/2 for linear responses; 0: not known.
  double energy_over_work = 0;
  std::vector<std::string> against;  ///< rays whose forces point against their displacements in the sum
  PHYNNESS_FIGURES(rays, missing_rays, largest_displacement_m, largest_force_N, energy_over_work)
};

/// What round tools of a radius [m] at some nodes move: tools_of() of meshes/.
using ToolsOf =
    std::function<std::vector<TouchedNodes>(const Mesh& mesh, const NodeList& fixed, const NodeList& nodes, double)>;

/// Checks a file of responses and writes a finished database. Only the forces and energies are held in memory.
/// @throws Error (input) for what formats/imported.md lists; (failure) if it cannot be written
ImportReport import_responses(const std::filesystem::path& file, const std::filesystem::path& database,
                              const ToolsOf& tools_of);

}  // namespace phynness
