// Discrete-event simulation of precompute() on many ranks: which rank solves which ray at which time, and what it waits
// for. The tasks are those of phynness/formats/ray_tasks.hpp, which precompute() distributes; there is no other
// schedule.
#pragma once

#include <cstddef>
#include <cstdint>
#include <phynness/formats/ray_tasks.hpp>
#include <vector>

namespace phynness {

/// Work to be done.
struct RayWork {
  std::vector<RayIndex> rays;   ///< in the order of rays_left()
  std::vector<double> seconds;  ///< CPU time of each ray [s]; 0: not requested, recorded without a solve
  double bytes_per_ray = 0;     ///< size of a record in a log

  std::size_t n_rays() const { return rays.size(); }
  double total_seconds() const;
  double longest_seconds() const;
};

/// Costs of the machine in seconds. All may be zero except the bandwidth.
struct MachineCosts {
  double launch_s = 0;              ///< per rank, all at once: loading the program
  double start_s = 0;               ///< per rank, all at once: reading the scene, building the discretization
  double node_setup_s = 0;          ///< each time a rank starts with another active node
  double fetch_latency_s = 0;       ///< round trip to the counter of tasks
  double fetch_service_s = 0;       ///< the counter serves one rank at a time
  double log_create_s = 0;          ///< the file system creates one log at a time
  double log_s_per_ray = 0;         ///< CPU time of writing a record; every rank has its own log
  double bandwidth_B_per_s = 1e12;  ///< of the file system, for all ranks together
  double pack_log_open_s = 0;       ///< packing: opening and indexing a log, on one rank
  double pack_s_per_ray = 0;        ///< packing: reading, compressing and writing a ray, on one rank
};

/// Composition of ranks * wall seconds. The sum of the parts is the whole.
struct CoreSeconds {
  double solving = 0;  ///< rays
  double node_setup = 0;
  double start = 0;     ///< launch, start, creation of logs and waiting for it
  double fetching = 0;  ///< tasks: latency, and waiting for the counter
  double writing = 0;   ///< records, and waiting for the file system
  double tail = 0;      ///< waiting without a task for ranks that still work
  double packing = 0;   ///< one rank packs, all others wait

  double sum() const { return solving + node_setup + start + fetching + writing + tail + packing; }
};

/// A task and the rank that took it.
struct TakenTask {
  std::int64_t first = 0, end = 0;  ///< RayWork::rays[first ... end - 1]
  int rank = 0;
};

struct Schedule {
  int ranks = 1;
  double wall_s = 0;
  double solved_s = 0;           ///< time at which the last rank finds no more tasks
  std::vector<TakenTask> tasks;  ///< in the order of their distribution
  CoreSeconds spent;
};

/// Simulates one run. Events at equal times are processed in the order of ranks, so that the result is reproducible.
/// @pre ranks >= 1, all costs finite and not negative
Schedule simulate(const RayWork& work, const MachineCosts& machine, int ranks);

}  // namespace phynness
