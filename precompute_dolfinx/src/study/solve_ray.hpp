// Solves one ray and stores it in the layout of the database.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// CPU time of this process [s].
double cpu_seconds();

/// A ray of which no increment could be solved.
Ray failed_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

/// Calls ProbeSolver::recover() and logs its failure, after which the next solve calls it again.
void recover(ProbeSolver& solver);

/// Solves a ray. An exception of the solver ends the ray with Status::library_error; the reason is in the solver's log.
/// The result does not depend on earlier solves.
/// @pre the solver touches the active node
Ray solve_ray(ProbeSolver& solver, const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

/// @param point  index into sets.linear
AtRest response_at_rest(ProbeSolver& solver, const DatabaseHeader& header, std::int32_t point);

}  // namespace phynness
