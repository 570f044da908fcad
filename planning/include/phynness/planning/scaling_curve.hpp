// How many ranks a scene can use, and what stops more of them.
#pragma once

#include <phynness/planning/schedule.hpp>

namespace phynness {

/// Wall time on one rank over ranks * wall time.
double efficiency(const Schedule& one_rank, const Schedule& many);

/// What most of the core-seconds beyond those of one rank go into.
enum class Limit {
  nothing,      ///< on one rank
  start,        ///< loading the program, reading the scene, making logs
  node_setup,   ///< several ranks share a node, and each turns to it
  fetching,     ///< the counter of tasks
  writing,      ///< the bandwidth of the file system
  n_rays,       ///< waiting at the end: there are no more rays than ranks
  longest_ray,  ///< waiting at the end: one ray takes more than half of the time for solving
  last_rays,    ///< waiting at the end, for several rays
  packing,      ///< which one rank does alone
};
Limit limited_by(const Schedule& one_rank, const Schedule& many, const RayWork& work, const MachineCosts& machine);

/// "longest_ray"
const char* name(Limit limit);

/// The most ranks, 1 to `most`, below which the efficiency has never been seen under `wanted`: looked at in
/// steps of a tenth, then halved down to one rank. Where the last rays divide badly the curve may come back
/// above it.
int ranks_at_efficiency(double wanted, const RayWork& work, const MachineCosts& machine, int most);

}  // namespace phynness
