// Times of the runtime on this machine.
#pragma once

#include <phynness/validation/named_organ.hpp>

namespace phynness {

/// Median times of one call of the runtime in one thread. Deformations are those of prepared nodes (phn_prepare).
struct RuntimeSpeed {
  double force_us = 0, deformation_us = 0;
  double field_us = 0;  ///< time of one scalar field; 0 if the model has no fields
};
RuntimeSpeed measure_speed(const NamedOrgan& model);

/// Median time [us] of a call of phn_body_force with one step of Newton's method. Tools at `nodes` move by a hundredth
/// of the trained depth between calls.
/// @param nodes  at most PHN_MOST_COUPLED, surface nodes of the body that are not fixed
double measure_step_us(const NamedOrgan& body, std::span<const std::int32_t> nodes);

}  // namespace phynness
