// The numbers of new solves that calibrate and validate a model.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>

namespace phynness {

struct CheckSizes {
  std::int64_t calibration_rays = 0;
  std::int64_t probes = 0;  ///< of the validation
  /// Estimated numbers of solved increments.
  double calibration_increments = 0, validation_increments = 0;
};

/// The sizes in [validation] of the scene. By default both checks together solve half as many increments as the
/// database, with 100 to 1,000 rays and 50 to 200 probes.
/// @param header   header of the scene's database
/// @param bounded  false for a family without bounds, which has no calibration
CheckSizes sizes_of_checks(const Scene& scene, const DatabaseHeader& header, bool bounded);

}  // namespace phynness
