// How long the runtime takes on this machine.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <vector>

namespace phynness {

/// Median time of one call of the runtime on this machine, this process alone; deformations of nodes that are
/// ready (phn_prepare).
struct RuntimeSpeed {
  double force_us = 0, deformation_us = 0;
  double field_us = 0;  ///< of one field; 0: the model has none
};
RuntimeSpeed measure_speed(const LoadedModel& model);

/// Times of each level by phn_calibrate and this machine's steady clock.
std::vector<phn_level_time> measure_levels(const LoadedModel& model);

}  // namespace phynness
