// Algorithm 1: every active node, every exploratory direction, every increment -> database.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <vector>

namespace phynness {

/// Where the responses go, and who shares a solve.
struct PrecomputeTarget {
  std::filesystem::path file;
  bool resume = false;
  std::optional<Shard> shard;  ///< solve its rays only, and leave them in the log of `file` for a merge
  int ranks_per_solve = 1;     ///< consecutive ranks that factorize together, for large meshes
};

/// One rank's part of a run.
struct RankFigures {
  std::int64_t rays = 0, tasks = 0;  ///< tasks: of phynness/formats/ray_tasks.hpp
  double busy_seconds = 0;           ///< wall time spent solving and logging
  double idle_seconds = 0;           ///< the rest of the time until the last rank had solved its last ray
  double core_seconds = 0;           ///< CPU time; waiting for other ranks left out
  double peak_memory_bytes = 0;
};

struct PrecomputeReport {
  std::int64_t rays = 0, rays_resumed = 0;  ///< solved now, found in the logs
  std::int64_t rays_mirrored = 0;           ///< made from others by a plane of symmetry; none in a shard
  /// Of the whole database, or, for a shard or an interrupted run, of what was solved now. failed:
  /// after_failure included.
  std::int64_t increments = 0, failed = 0, iterations = 0;
  std::int64_t library_errors = 0;            ///< rays of this run that Status::library_error ended
  std::int64_t increments_solved = 0;         ///< of the increments, those that are not mirror images
  std::int64_t increments_of_run = 0;         ///< those that this run solved
  double wall_seconds = 0, core_seconds = 0;  ///< of this run; core_seconds summed over ranks
  double setup_seconds = 0, solve_seconds = 0, pack_seconds = 0;  ///< parts of wall_seconds
  std::vector<RankFigures> ranks;                                 ///< on rank 0; empty elsewhere
  bool interrupted = false;                                       ///< finished rays are kept; --resume goes on
};

/// (rays done over all ranks, rays in all); on rank 0 only. Called often; draw at your own pace.
using PrecomputeProgress = std::function<void(std::int64_t, std::int64_t)>;

/// Collective over MPI_COMM_WORLD: all ranks call it with the same arguments. Rays are handed out to
/// whichever rank is free, node by node, in ever smaller portions. Every ray starts at rest, so the result
/// does not depend on who solves it.
/// @pre ranks_per_solve divides the number of ranks
/// @pre this process holds the DatabaseLock of the file, on rank 0
/// A ray that cannot be solved is recorded as failed, with its reason, whatever the reason; messages of
/// libraries go to `<target.file>.solver.log`.
/// @param stop  polled between rays on every rank; true ends the run early with what is finished kept
/// @param warn  told at once on the rank that cannot go on (its file system is full, say); the other ranks
/// end the nodes they work on before this throws
/// @throws Error
PrecomputeReport precompute(const SolverSession& session, const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                            const PrecomputeTarget& target, const PrecomputeProgress& progress = {},
                            const std::function<bool()>& stop = {},
                            const std::function<void(const std::string&)>& warn = {});

/// Header of the database that precompute() writes for a scene.
DatabaseHeader database_header(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

}  // namespace phynness
