// Ends of rays in files that do not record them.
#pragma once

#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// The end of a ray as far as the outcomes of its increments tell it.
RayEnd end_of(const std::vector<Status>& statuses, const std::vector<double>& magnitudes_m);

}  // namespace phynness
