// Where the error of a modal model comes from: modes left out, a fit that misses its data, or too few
// directions.
#pragma once

#include <phynness/validation/probed_states.hpp>

#include "study_models.hpp"

namespace phynness::study {

/// Means as in (17): of training states over their largest response, of fresh solves inside the trained range
/// over theirs.
struct ErrorParts {
  std::int32_t node = 0;
  double distance_to_fixed_m = 0, largest_force_N = 0;
  // Force: no truncation, as nothing is projected.
  double force_regression = 0;     ///< network at training states
  double force_total = 0;          ///< network
  double force_interpolation = 0;  ///< interpolation of all training states: what no fit of them can tell
  // Displacement.
  double truncation = 0;      ///< fresh fields from their projection on the stored modes
  double regression = 0;      ///< amplitudes' network from that projection, at training states
  double amplitudes = 0;      ///< the same of fresh fields: regression and sampling
  double total = 0;           ///< model
  double interpolation = 0;   ///< interpolation of all training fields, without modes
  double float_rounding = 0;  ///< largest difference of the runtime from the same sums in double
};

std::vector<ErrorParts> error_parts(const StudyData& data, const StudiedModal& studied, const LoadedModel& model,
                                    const std::vector<NodeProbes>& probes);

}  // namespace phynness::study
