// Shares of the probe volume, of a database and of a model.
#pragma once

#include <algorithm>
#include <cmath>

namespace phynness {

/// Part of the probes of a direction up to `range_m` that lie before a depth: they fill a cone around it.
inline double part_of_volume(double depth_m, double range_m) { return std::pow(std::min(1.0, depth_m / range_m), 3); }

}  // namespace phynness
