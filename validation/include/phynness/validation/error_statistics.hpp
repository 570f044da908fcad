// Mean, median, 95th percentile and maximum of errors.
#pragma once

#include <cstdint>
#include <vector>

namespace phynness {

/// Fractions. Without samples all members are 0.
struct ErrorStatistics {
  double mean = 0, median = 0, p95 = 0, max = 0;
  std::int64_t n = 0;
  static ErrorStatistics of(std::vector<double> samples);
};

}  // namespace phynness
