// Measurement of the time of a call on a machine with other load.
#pragma once

#include <algorithm>
#include <ctime>
#include <functional>
#include <vector>

namespace phynness::bench {

/// Processor time for n calls [us], which does not depend on other processes.
inline double time_of(int n, const std::function<void(int)>& call) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  for (int i = 0; i < n; ++i) call(i);
  return now() - start;
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Number of calls that take half a millisecond.
inline int calls_of_a_batch(const std::function<void(int)>& call) {
  int n = 1;
  while (time_of(n, call) < 500) n *= 2;
  return n;
}

/// Median over batches of the mean time of a call in a batch [us]. A batch takes half a millisecond or has one call.
inline double median_us(const std::function<void(int)>& call) {
  const int n = calls_of_a_batch(call);
  const auto n_batches = static_cast<std::size_t>(std::clamp(2e6 / time_of(n, call), 11.0, 501.0));
  std::vector<double> times;
  for (std::size_t b = 0; b < n_batches; ++b) times.push_back(time_of(n, call) / n);
  return median(times);
}

/// Times of several calls, measured in turn, so that a temporary slowdown of the processor affects all of them.
struct SideBySide {
  std::vector<double> us;     ///< medians
  std::vector<double> ratio;  ///< median over rounds of the time over that of the first call in the same round
};
inline SideBySide side_by_side(const std::vector<std::function<void(int)>>& calls) {
  constexpr std::size_t n_rounds = 401;
  std::vector<int> n;
  for (const auto& call : calls) n.push_back(calls_of_a_batch(call));
  std::vector<std::vector<double>> times(calls.size()), ratios(calls.size());
  for (std::size_t round = 0; round < n_rounds; ++round)
    for (std::size_t c = 0; c < calls.size(); ++c) {
      times[c].push_back(time_of(n[c], calls[c]) / n[c]);
      ratios[c].push_back(times[c].back() / times[0].back());
    }
  SideBySide result;
  for (std::size_t c = 0; c < calls.size(); ++c) {
    result.us.push_back(median(times[c]));
    result.ratio.push_back(median(ratios[c]));
  }
  return result;
}

}  // namespace phynness::bench
