// How many ranks a scene can use, and what stops more of them.
#pragma once

#include <phynness/planning/schedule.hpp>
#include <string>

namespace phynness {

/// Wall time on one rank over ranks * wall time. `one_rank` may be of another policy, so that policies
/// compare.
double efficiency(const Schedule& one_rank, const Schedule& many);

/// What most of the core-seconds beyond those of one rank go into: "start-up", "node set-up", "fetching
/// tasks", "writing", "tail of long rays", "packing"; "nothing" on one rank.
std::string limited_by(const Schedule& one_rank, const Schedule& many);

/// The most ranks, 1 to `most`, below which the efficiency has never been seen under `wanted`: looked at in
/// steps of a tenth, then halved down to one rank. Where the last rays divide badly the curve may come back
/// above it.
int ranks_at_efficiency(double wanted, const Schedule& one_rank, const RayWork& work,
                        const MachineCosts& machine, const Policy& policy, int most);

}  // namespace phynness
