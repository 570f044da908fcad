// Checks of the numbers of a ray when it is read from a database or from a log.
#pragma once

#include <string>
#include <vector>

#include "ray_columns.hpp"

namespace phynness {

/// The first impossible number of some columns (ColumnKind), for example "/responses/seconds, increment 17, is nan";
/// empty if all are possible.
/// @param ray         also all increments of a database as one ray
/// @param farthest_m  bound of displacements (database_checks.hpp)
/// @pre the columns have values; that of the outcomes comes first, or all have one value per ray
std::string ray_defect(const Ray& ray, const std::vector<StoredColumn>& columns, double farthest_m);

}  // namespace phynness
