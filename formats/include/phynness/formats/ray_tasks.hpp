// How the rays that are left are cut into tasks for ranks that take them one after the other. precompute()
// hands out these tasks, and `phynness plan` simulates them.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// Indices into the active nodes and the directions.
struct RayIndex {
  std::int32_t active = 0, direction = 0;
};

/// The rays of a database that its shard owns (all without a shard), that are no mirror images of others and
/// that `logged` has not, node by node.
/// @param logged  n_active x n_directions flags
std::vector<RayIndex> rays_left(const DatabaseHeader& header, const std::vector<char>& logged);

/// Where each task begins, then rays.size(). A task is of one node, as touching a node costs a factorization:
/// all of its rays while there are many left, a share of what is left once that is less, single rays at the
/// end, so that all ranks end together (guided self-scheduling: Polychronopoulos & Kuck 1987,
/// doi 10.1109/TC.1987.5009495).
/// @param rays  sorted by active node
/// @pre n_ranks > 0
std::vector<std::int64_t> ray_tasks(const std::vector<RayIndex>& rays, int n_ranks);

}  // namespace phynness
