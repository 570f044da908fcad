// One ray, solved and put into the form that the database stores.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// CPU time of this process [s].
double cpu_seconds();

/// A ray of which nothing was requested.
Ray empty_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

/// A ray of which nothing could be solved.
Ray failed_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

/// ProbeSolver::recover(), and again before the next solve if that fails for want of memory.
void recover(ProbeSolver& solver);

/// What the solver cannot handle ends the ray with Status::library_error, and the solver's log has the
/// reason.
/// @pre the solver touches the active node. The result depends on nothing that it solved before.
Ray solve_ray(ProbeSolver& solver, const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

}  // namespace phynness
