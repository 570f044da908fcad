// How fast the runtime answers on this machine.
#pragma once

#include <phynness/validation/named_organ.hpp>

namespace phynness {

/// Median times of one call of the runtime in one thread; deformations of prepared nodes (phn_prepare).
struct RuntimeSpeed {
  double force_us = 0, deformation_us = 0;
  double field_us = 0;  ///< of one scalar field; 0: the model has no fields
};
RuntimeSpeed measure_speed(const NamedOrgan& model);

/// Median time [us] of a call of phn_body_force with one step of Newton's method, with tools at `nodes`, of which each
/// moves by a hundredth of the trained depth from call to call.
/// @param nodes  at most PHN_MOST_COUPLED, surface nodes of the body that are not fixed
double measure_step_us(const NamedOrgan& body, std::span<const std::int32_t> nodes);

}  // namespace phynness
