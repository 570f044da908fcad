// What one core of this machine can do at most, measured.
#pragma once

#include <cstddef>

namespace phynness::bench {

struct MachineLimits {
  double double_gflops, float_gflops;  ///< additions and multiplications, not fused: the runtime fuses none
};
MachineLimits machine_limits();

/// Bytes read once from front to back, over and over [GB/s].
double read_rate(std::size_t bytes);

}  // namespace phynness::bench
