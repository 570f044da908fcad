// Checks of the numbers of a ray when it is read from a database or from a log.
#pragma once

#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Figures of the increments of one ray, of all rays of a node, or of all rays, as they are stored.
struct StateFigures {
  std::vector<std::int8_t> status;
  std::vector<std::int32_t> negative_pivots, iterations, cutbacks;
  std::vector<double> min_jacobian, seconds;
};

/// The first impossible number: an unknown outcome, a negative count or time, or a J that is not finite in a converged
/// increment.
/// @return for example "/responses/seconds, increment 17, is nan"; empty if all are possible
std::string figures_defect(const StateFigures& figures);

/// The first impossible number among ends of rays: an unknown reason, a depth that is negative or not finite, or an
/// energy that is not finite. Empty if all are possible.
std::string ends_defect(const std::vector<RayEnd>& ends);

/// The same for a complete ray. In addition forces, energies, tangents, displacements and fields of converged
/// increments must be finite, and displacements must not exceed `farthest_m` (database_checks.hpp).
/// @pre the arrays have the sizes described in Ray
std::string ray_defect(const Ray& ray, const std::vector<Field>& fields, double farthest_m);

}  // namespace phynness
