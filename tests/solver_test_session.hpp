// The session of a test program that solves.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

namespace phynness::test {

/// @pre a test is running
const SolverSession& solver_session();

}  // namespace phynness::test
