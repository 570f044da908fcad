// How large the levels of a model are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace phynness {

/// Below these a level saves no time that could be noticed, and tells little more than a linear body would.
inline constexpr int least_force_centers = 4, least_amplitude_centers = 8, least_modes = 2, least_neurons = 8;

/// Half as many for each level below the full one. @param below  0: the full level
inline int level_size(int full, int below, int least) {
  const int step = 1 << below;
  return std::min(full, std::max(least, (full + step - 1) / step));
}

/// The first n of a list, ascending: centers of a level among those of the model, which were chosen in this
/// order.
inline std::vector<std::int32_t> first_sorted(const std::vector<std::int32_t>& order, int n) {
  std::vector<std::int32_t> some(order.begin(), order.begin() + std::min(n, static_cast<int>(order.size())));
  std::sort(some.begin(), some.end());
  return some;
}

}  // namespace phynness
