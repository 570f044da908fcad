// How long a call takes on a machine where others compute too.
#pragma once

#include <algorithm>
#include <ctime>
#include <functional>
#include <vector>

namespace phynness::bench {

/// Median over batches of the mean time of a call in a batch [us], in time of the processor, so that it does
/// not matter who else computes beside. Batches of half a millisecond or one call.
inline double median_us(const std::function<void(int)>& call) {
  const auto time_of = [&](int n) {
    const auto now = [] {
      timespec t{};
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
      return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
    };
    const double start = now();
    for (int i = 0; i < n; ++i) call(i);
    return now() - start;
  };
  int n = 1;
  while (time_of(n) < 500) n *= 2;
  const auto n_batches = static_cast<std::size_t>(std::clamp(2e6 / time_of(n), 11.0, 501.0));
  std::vector<double> times;
  for (std::size_t b = 0; b < n_batches; ++b) times.push_back(time_of(n) / n);
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(n_batches / 2), times.end());
  return times[n_batches / 2];
}

}  // namespace phynness::bench
