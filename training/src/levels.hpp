// Sizes of the levels of a model.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace phynness {

/// Smallest sizes. A smaller level would not save noticeable time, and would hardly be better than a linear model.
inline constexpr int least_force_centers = 4, least_amplitude_centers = 8, least_modes = 2, least_neurons = 8;

/// The size is halved for each level below the full one. @param below  number of levels below the full one
inline int level_size(int full, int below, int least) {
  const int step = 1 << below;
  return std::min(full, std::max(least, (full + step - 1) / step));
}

/// The first n of a list, in ascending order: the centers of a level, from the centers of the model in the order of
/// their selection.
inline std::vector<std::int32_t> first_sorted(const std::vector<std::int32_t>& order, int n) {
  std::vector<std::int32_t> some(order.begin(), order.begin() + std::min(n, static_cast<int>(order.size())));
  std::sort(some.begin(), some.end());
  return some;
}

}  // namespace phynness
