#include <algorithm>
#include <phynness/precompute/ray_tasks.hpp>

namespace phynness {

std::vector<RayIndex> remaining_rays(const DatabaseHeader& header, const std::vector<char>& logged) {
  const std::size_t n_directions = header.directions.size();
  std::vector<RayIndex> rays;
  for (std::size_t ray = 0; ray < logged.size(); ++ray)
    if (!logged[ray])
      rays.push_back({static_cast<std::int32_t>(ray / n_directions), static_cast<std::int32_t>(ray % n_directions)});
  if (header.sets.fixed.empty()) return rays;
  const Points fixed = header.mesh.nodes(header.sets.fixed, Eigen::all);
  std::vector<double> distance;
  for (const auto node : header.sets.active)
    distance.push_back((fixed.rowwise() - header.mesh.nodes.row(node)).rowwise().squaredNorm().minCoeff());
  std::ranges::stable_sort(rays, {},
                           [&](const RayIndex& ray) { return distance[static_cast<std::size_t>(ray.active)]; });
  return rays;
}

std::vector<std::int64_t> ray_tasks(const std::vector<RayIndex>& rays, int n_ranks) {
  const auto n = static_cast<std::int64_t>(rays.size());
  // An eighth of a rank's share of the remaining rays: some rays take ten times as long as others, and the preparation
  // of a node takes a twentieth of a ray.
  const std::int64_t shares = std::int64_t{8} * n_ranks;
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
