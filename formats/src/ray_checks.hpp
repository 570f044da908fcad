// What the numbers of a ray may be, checked where they are read, from the file as from logs.
#pragma once

#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Numbers of increments as they are stored: of one ray, of the rays of a node, or of all.
struct StateFigures {
  std::vector<std::int8_t> status;
  std::vector<std::int32_t> negative_pivots, iterations, cutbacks;
  std::vector<double> min_jacobian, seconds;
};

/// The first number that cannot be: an outcome that does not exist, a negative count or time, a J that is not
/// finite where the increment converged.
/// @returns "/responses/seconds, increment 17, is nan"; empty if there is none
std::string figures_defect(const StateFigures& figures);

/// The same of a whole ray: also forces, energies, tangents, displacements and fields of converged increments
/// must be finite, and displacements no larger than `farthest_m` (database_checks.hpp).
/// @pre the arrays have the sizes that Ray says
std::string ray_defect(const Ray& ray, const std::vector<Field>& fields, double farthest_m);

}  // namespace phynness
