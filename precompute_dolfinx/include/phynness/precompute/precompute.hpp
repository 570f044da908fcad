// Algorithm 1: every active node, every exploratory direction, every increment -> database.
#pragma once

#include <filesystem>
#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

struct PrecomputeReport {
  std::int64_t rays = 0, rays_resumed = 0;  ///< solved now, found in the logs
  std::int64_t rays_mirrored = 0;           ///< made from others by a plane of symmetry
  std::int64_t increments = 0, failed = 0;  ///< of the whole database; failed: after_failure included
  std::int64_t increments_solved = 0;       ///< of them, those that are not mirror images
  std::int64_t iterations = 0;
  double wall_seconds = 0, core_seconds = 0;  ///< of this run; core_seconds summed over ranks
  bool interrupted = false;                   ///< finished rays are kept; --resume goes on
};

/// (rays done over all ranks, rays in all); on rank 0 only. Called often; draw at your own pace.
using PrecomputeProgress = std::function<void(std::int64_t, std::int64_t)>;

/// Collective over MPI_COMM_WORLD: all ranks call it with the same arguments. Active nodes are handed out one
/// at a time to whichever rank is free. Every ray starts at rest, so the result does not depend on who solves
/// it.
/// @param stop  polled between rays on every rank; true ends the run early with what is finished kept
/// @throws Error
PrecomputeReport precompute(const SolverSession& session, const Scene& scene, const Mesh& mesh,
                            const NodeSets& sets, const std::filesystem::path& file, bool resume,
                            const PrecomputeProgress& progress = {}, const std::function<bool()>& stop = {});

/// Header of the database that precompute() writes for a scene.
DatabaseHeader database_header(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

}  // namespace phynness
