#include "ray_schedule.hpp"

#include <algorithm>

namespace phynness {

std::vector<RayIndex> rays_left(const DatabaseHeader& header, const std::vector<char>& logged) {
  const auto n_active = static_cast<std::int32_t>(header.sets.active.size());
  const auto n_directions = static_cast<std::int32_t>(header.directions.size());
  std::vector<RayIndex> rays;
  for (std::int32_t a = 0; a < n_active; ++a)
    for (std::int32_t d = 0; d < n_directions; ++d) {
      const bool owned =
          !header.shard || shard_of(a, d, n_active, n_directions, header.shard->count) == header.shard->index;
      if (owned &&
          !logged[static_cast<std::size_t>(a) * header.directions.size() + static_cast<std::size_t>(d)])
        rays.push_back({a, d});
    }
  return rays;
}

std::vector<std::int64_t> ray_tasks(const std::vector<RayIndex>& rays, int n_ranks) {
  const auto n = static_cast<std::int64_t>(rays.size());
  // An even share: half of one, as for loops whose parts cost nothing to begin, ends no sooner, as each task
  // may touch its node anew.
  const std::int64_t shares = n_ranks;
  std::vector<std::int64_t> starts{0};
  while (starts.back() < n) {
    const auto begin = starts.back();
    const auto longest = begin + (n - begin + shares - 1) / shares;
    auto end = begin + 1;
    while (end < longest &&
           rays[static_cast<std::size_t>(end)].active == rays[static_cast<std::size_t>(begin)].active)
      ++end;
    starts.push_back(end);
  }
  return starts;
}

}  // namespace phynness
