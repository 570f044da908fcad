// Discrete-event simulation of precompute() on many ranks: who solves which ray when, and what everybody
// waits for. The tasks are those of phynness/formats/ray_tasks.hpp, which precompute() hands out; no other
// schedule exists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <phynness/formats/ray_tasks.hpp>
#include <vector>

namespace phynness {

/// What is to be solved.
struct RayWork {
  std::vector<RayIndex> rays;   ///< as rays_left() orders them
  std::vector<double> seconds;  ///< CPU time of each ray [s]; 0: not asked for, recorded without a solve
  double bytes_per_ray = 0;     ///< of a record in a log

  std::size_t n_rays() const { return rays.size(); }
  double total_seconds() const;
  double longest_seconds() const;
};

/// The machine, in seconds. Zeros are allowed everywhere except the bandwidth.
struct MachineCosts {
  double launch_s = 0;              ///< per rank, all at once: loading the program
  double start_s = 0;               ///< per rank, all at once: reading the scene, building the discretization
  double node_setup_s = 0;          ///< whenever a rank turns to another active node
  double fetch_latency_s = 0;       ///< round trip to the counter of tasks
  double fetch_service_s = 0;       ///< the counter serves one rank at a time
  double log_create_s = 0;          ///< the file system makes one log at a time
  double log_s_per_ray = 0;         ///< CPU time of writing a record; every rank has a log of its own
  double bandwidth_B_per_s = 1e12;  ///< of the file system, for all ranks together
  double pack_log_open_s = 0;       ///< packing opens and indexes each log, alone
  double pack_s_per_ray = 0;        ///< packing: reading, compressing, writing a ray, alone
};

/// Where ranks * wall seconds went. The parts add up to it.
struct CoreSeconds {
  double solving = 0;  ///< rays
  double node_setup = 0;
  double start = 0;     ///< launch, start, creation of logs with the waiting for it
  double fetching = 0;  ///< tasks: latency, and waiting for the counter
  double writing = 0;   ///< records, and waiting for the file system
  double tail = 0;      ///< no task left, others still at work
  double packing = 0;   ///< one rank packs, the others wait

  double sum() const { return solving + node_setup + start + fetching + writing + tail + packing; }
};

/// A task, and who took it.
struct TakenTask {
  std::int64_t first = 0, end = 0;  ///< RayWork::rays[first ... end - 1]
  int rank = 0;
};

struct Schedule {
  int ranks = 1;
  double wall_s = 0;
  double solved_s = 0;           ///< when the last rank ran out of tasks
  std::vector<TakenTask> tasks;  ///< in the order in which they were handed out
  CoreSeconds spent;
};

/// Simulates one run. Events at equal times are served in the order of ranks, so the result is reproducible.
/// @pre ranks >= 1, all costs finite and not negative
Schedule simulate(const RayWork& work, const MachineCosts& machine, int ranks);

}  // namespace phynness
