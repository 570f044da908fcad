// The remaining rays of a database, and their division into tasks, which the ranks of precompute() fetch.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// Indices of an active node and a direction.
struct RayIndex {
  std::int32_t active = 0, direction = 0;
};

/// The rays that are not yet logged, grouped by node. Nodes near fixed nodes come first, because their rays take
/// longest.
/// @param logged  n_active x n_directions flags
std::vector<RayIndex> remaining_rays(const DatabaseHeader& header, const std::vector<char>& logged);

/// The first ray of each task, followed by rays.size(). A task has rays of one node, because each change of the node
/// costs a factorization. The size of the tasks decreases from all rays of a node to a single ray, so that all ranks
/// end at about the same time (guided self-scheduling: Polychronopoulos & Kuck 1987, doi 10.1109/TC.1987.5009495).
/// @param rays  grouped by node
/// @pre n_ranks > 0
std::vector<std::int64_t> ray_tasks(const std::vector<RayIndex>& rays, int n_ranks);

}  // namespace phynness
