#include <phynness/formats/mirrored_rays.hpp>
#include <phynness/formats/ray_tasks.hpp>

namespace phynness {

std::vector<RayIndex> rays_left(const DatabaseHeader& header, const std::vector<char>& logged) {
  const std::size_t n_directions = header.directions.size();
  const Shard shard = header.shard.value_or(Shard{0, 1});
  const auto owners = shards_of_rays(MirroredRays(header).solved(), n_directions, shard.count);
  std::vector<RayIndex> rays;
  for (std::size_t ray = 0; ray < owners.size(); ++ray)
    if (owners[ray] == shard.index && !logged[ray])
      rays.push_back({static_cast<std::int32_t>(ray / n_directions), static_cast<std::int32_t>(ray % n_directions)});
  return rays;
}

std::vector<std::int64_t> ray_tasks(const std::vector<RayIndex>& rays, int n_ranks) {
  const auto n = static_cast<std::int64_t>(rays.size());
  // Each task is a full share of the remaining rays. Half a share, as for loops without a start-up cost, does not end
  // earlier, because each task may have to prepare its node again.
  const std::int64_t shares = n_ranks;
  std::vector<std::int64_t> starts{0};
  while (starts.back() < n) {
    const auto begin = starts.back();
    const auto longest = begin + (n - begin + shares - 1) / shares;
    auto end = begin + 1;
    while (end < longest && rays[static_cast<std::size_t>(end)].active == rays[static_cast<std::size_t>(begin)].active)
      ++end;
    starts.push_back(end);
  }
  return starts;
}

}  // namespace phynness
