// The number of ranks that a scene can use, and what limits it.
#pragma once

#include <phynness/planning/schedule.hpp>

namespace phynness {

/// Wall time on one rank over ranks * wall time.
double efficiency(const Schedule& one_rank, const Schedule& many);

/// The largest part of the core-seconds that exceed those of one rank.
enum class Limit {
  nothing,      ///< on one rank
  start,        ///< loading the program, reading the scene, creating logs
  node_setup,   ///< several ranks share a node, and each of them prepares it
  fetching,     ///< the counter of tasks
  writing,      ///< the bandwidth of the file system
  n_rays,       ///< waiting at the end: there are at most as many rays as ranks
  longest_ray,  ///< waiting at the end: one ray takes more than half of the time for solving
  last_rays,    ///< waiting at the end, for several rays
  packing,      ///< on one rank
};
Limit limited_by(const Schedule& one_rank, const Schedule& many, const RayWork& work, const MachineCosts& machine);

/// "longest_ray"
const char* name(Limit limit);

/// The largest number of ranks, 1 to `most`, up to which the efficiency was at least `wanted` at all tried numbers.
/// Numbers are tried in steps of a tenth, then halved down to one rank. With larger numbers of ranks the efficiency may
/// exceed `wanted` again, if the last rays are distributed better.
int ranks_at_efficiency(double wanted, const RayWork& work, const MachineCosts& machine, int most);

}  // namespace phynness
