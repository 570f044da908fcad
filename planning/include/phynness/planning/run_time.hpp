// Wall time of a precompute run on many ranks, from the costs of a mean ray and of the longest one.
#pragma once

#include <cstdint>

namespace phynness {

/// CPU times.
struct RunCosts {
  double start_s = 0;    ///< of each rank: scene, mesh, discretization
  double ray_s = 0;      ///< mean
  double longest_s = 0;  ///< of a ray
  double setup_s = 0;    ///< each time that a rank begins with a node
  double packing_s = 0;  ///< on one rank, while the others wait
  std::int64_t rays = 0, nodes = 0;
};

/// start + max((rays ray + (nodes + ranks - 1) setup) / ranks, longest + setup) + packing: ranks take small tasks until
/// the end, where they share nodes and may wait for one long ray. Reading, writing and launching are not in it.
double wall_seconds(const RunCosts& costs, int ranks);

/// The largest number of ranks, at most one per ray, that spend at least half of their time as usefully as one rank.
int ranks_of_use(const RunCosts& costs);

}  // namespace phynness
