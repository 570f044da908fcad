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

}  // namespace phynness
