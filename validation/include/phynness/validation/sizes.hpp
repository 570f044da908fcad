// How many fresh solves calibrate and validate a model, beside those of its database.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>

namespace phynness {

struct CheckSizes {
  std::int64_t calibration_rays = 0;
  std::int64_t probes = 0;  ///< of the validation
  /// Increments that they solve, about.
  double calibration_increments = 0, validation_increments = 0;
};

/// The sizes that [validation] of the scene gives. A size that it does not give is such that both together solve half
/// as many increments as the database has, but at least 100 rays and 50 probes, and at most
/// 1,000 rays and 200 probes.
/// @param header   of the scene's database; its active nodes and directions count
/// @param bounded  false for a family whose error needs no bounds; it has no calibration
CheckSizes sizes_of_checks(const Scene& scene, const DatabaseHeader& header, bool bounded);

}  // namespace phynness
