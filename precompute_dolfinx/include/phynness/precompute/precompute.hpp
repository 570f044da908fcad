// Algorithm 1 of the paper: solves all increments in all exploratory directions at all active nodes and writes a
// database.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <string>

namespace phynness {

/// Part `index`, from 0, of `count` about equal parts of the rays, which independent processes solve.
struct RayPart {
  int index = 0, count = 1;
  std::string str() const { return std::to_string(index) + "/" + std::to_string(count); }
};

/// The database that receives the responses.
struct PrecomputeTarget {
  std::filesystem::path file;
  bool resume = false;
  std::optional<RayPart> part;  ///< only these rays are solved; a run without a part packs their logs
  std::filesystem::path from;   ///< database of Coverage::part whose rays are copied, finished or not; may be empty
};

/// Sums over rays of one rank or of all ranks, of this run or of the whole database. `failed` includes after_failure.
struct RayCounts {
  std::int64_t rays = 0, rays_solved = 0;      ///< all rays, and requested rays
  std::int64_t increments = 0, after_end = 0;  ///< attempted increments, and those beyond the end of their ray
  std::int64_t failed = 0, iterations = 0,
               library_errors = 0;  ///< library_errors counts increments with Status::library_error
};

/// Rays and library errors are those of this run. Increments and iterations are those of the whole database or, for a
/// part or an interrupted run, of this run; after_end is 0 there.
struct PrecomputeReport : RayCounts {
  std::int64_t rays_resumed = 0;              ///< rays found in the logs
  std::int64_t rays_taken = 0;                ///< rays copied from another database in this run
  std::int64_t increments_of_run = 0;         ///< increments solved by this run
  double wall_seconds = 0, core_seconds = 0;  ///< times of this run; core_seconds is the sum over ranks
  double setup_seconds = 0, solve_seconds = 0, pack_seconds = 0;  ///< parts of wall_seconds
  double at_rest_seconds = 0;    ///< part of pack_seconds in which rank 0 computes responses at rest
  double idle_share = 0;         ///< share of the solve time in which ranks wait for the last ray
  double peak_memory_bytes = 0;  ///< largest value of a rank
  bool interrupted = false;      ///< the run was stopped; --resume continues with the finished rays
  std::int64_t rays_found() const { return rays_resumed + rays_taken; }  ///< rays that this run did not solve
};

/// Called on rank 0 with the number of finished rays of all ranks and the total number. It is called often and should
/// limit its own output.
using PrecomputeProgress = std::function<void(std::int64_t, std::int64_t)>;

/// Collective over MPI_COMM_WORLD: all ranks call it with the same arguments. Free ranks fetch rays node by node, in
/// tasks of decreasing size. Every ray starts at rest, so that the result does not depend on the rank that solves it. A
/// ray that cannot be solved is recorded as failed with its reason. Messages of libraries go to
/// `<target.file>.solver.log`. The responses at rest come last, while the database is packed.
/// @pre without a part, rank 0 holds the DatabaseLock of the file
/// @param stop  polled between rays, and between iterations of a solve, on every rank; true ends the run and keeps
/// finished rays
/// @param warn  called immediately on a rank that cannot continue, for example because its file system is full; the
///              other ranks finish their present nodes before this function throws
/// @param at_rest  as `progress`, with the points whose response at rest is computed
/// @throws Error
PrecomputeReport precompute(const SolverSession& session, const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                            const PrecomputeTarget& target, const PrecomputeProgress& progress = {},
                            const std::function<bool()>& stop = {},
                            const std::function<void(const std::string&)>& warn = {},
                            const PrecomputeProgress& at_rest = {});
}  // namespace phynness
