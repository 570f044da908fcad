// Ranks that wait without a processor for what the first rank decides.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// What rank 0 says, on all ranks of a session. Collective.
bool told(const SolverSession& session, bool said);

}  // namespace phynness
