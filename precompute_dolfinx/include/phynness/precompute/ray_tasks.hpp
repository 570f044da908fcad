// The rays that are left, and their division into tasks, which the ranks of precompute() fetch one after the other.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// Indices of an active node and a direction.
struct RayIndex {
  std::int32_t active = 0, direction = 0;
};

/// The rays of a database that are not yet logged, node by node: first those near fixed nodes, which take longest, so
/// that no rank begins a long ray when the others end.
/// @param logged  n_active x n_directions flags
std::vector<RayIndex> rays_left(const DatabaseHeader& header, const std::vector<char>& logged);

/// First ray of each task, followed by rays.size(). A task belongs to one node, because each change of the node costs a
/// factorization. While many rays are left a task has all rays of the node, later a share of the remaining rays, at the
/// end a single ray, so that all ranks end at about the same time (guided self-scheduling: Polychronopoulos & Kuck
/// 1987, doi 10.1109/TC.1987.5009495).
/// @param rays  node by node
/// @pre n_ranks > 0
std::vector<std::int64_t> ray_tasks(const std::vector<RayIndex>& rays, int n_ranks);

}  // namespace phynness
