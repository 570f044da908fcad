// The tasks of a rank of precompute().
#pragma once

#include <exception>
#include <functional>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/ray_tasks.hpp>
#include <span>
#include <string>
#include <vector>

#include "solve/work_counter.hpp"

namespace phynness {

/// Adds a ray to the counts.
void count(std::span<const Status> statuses, std::span<const std::int32_t> iterations, RayCounts& sum);

/// The totals of one rank.
struct RankTotals {
  RayCounts counts;
  double busy_seconds = 0;
  bool interrupted = false;
};

/// Fetches and solves tasks until none is left or `stop` returns true.
/// @param done  called after every ray
void solve_tasks(ProbeSolver& solver, DatabaseWriter& log, const DatabaseHeader& header,
                 const std::vector<RayIndex>& rays, WorkCounter& counter, int n_ranks,
                 const std::function<void()>& done, const std::function<bool()>& stop, RankTotals& totals);

/// Runs the work of a rank. Returns its exception, after which the counter gives the other ranks no further tasks.
std::exception_ptr run_guarded(WorkCounter& counter, int rank, const std::function<void(const std::string&)>& warn,
                               const std::function<void()>& work);

}  // namespace phynness
