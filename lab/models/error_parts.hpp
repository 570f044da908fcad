// Sources of the error of a modal model: truncation of modes, residuals of the fit, or too few directions.
#pragma once

#include <phynness/validation/probed_states.hpp>

#include "study_models.hpp"

namespace phynness::study {

/// Means as in (17): of training states over their largest response, and of new solves inside the trained range over
/// theirs.
struct ErrorParts {
  std::int32_t node = 0;
  double distance_to_fixed_m = 0, largest_force_N = 0;
  // Force: there is no truncation, because nothing is projected.
  double force_regression = 0;     ///< network at training states
  double force_total = 0;          ///< network
  double force_interpolation = 0;  ///< interpolation of all training states, a lower bound for fits of them
  // Displacement.
  double truncation = 0;      ///< new fields compared with their projection on the stored modes
  double regression = 0;      ///< network of the amplitudes compared with the projection, at training states
  double amplitudes = 0;      ///< the same for new fields: regression and sampling
  double total = 0;           ///< model
  double interpolation = 0;   ///< interpolation of all training fields, without modes
  double float_rounding = 0;  ///< largest difference between the runtime and the same sums in double
};

std::vector<ErrorParts> error_parts(const StudyData& data, const StudiedModal& studied, const LoadedModel& model,
                                    const std::vector<NodeProbes>& probes);

}  // namespace phynness::study
