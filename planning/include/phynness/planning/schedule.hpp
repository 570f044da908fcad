// Discrete-event simulation of a precompute on many ranks: who solves which ray when, and what everybody
// waits for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace phynness {

/// What is to be solved. Rays stand in the database's order: all directions of the first active node, and so
/// on.
struct RayWork {
  std::vector<std::int32_t> node;  ///< n_rays: index of the active node; rays of a node are neighbours
  int increments = 1;
  std::vector<double> seconds;  ///< n_rays x increments: CPU time of each increment [s]
  double bytes_per_ray = 0;     ///< of a record in a log

  std::size_t n_rays() const { return node.size(); }
  double ray_seconds(std::size_t ray) const;
  double total_seconds() const;
};

/// The machine, in seconds. Zeros are allowed everywhere except the bandwidth.
struct MachineCosts {
  double launch_s = 0;              ///< per rank, all at once: loading the program
  double start_s = 0;               ///< per rank, all at once: reading the scene, building the discretization
  double node_setup_s = 0;          ///< whenever a rank turns to another active node
  double fetch_latency_s = 0;       ///< round trip to the counter of tasks
  double fetch_service_s = 0;       ///< the counter serves one rank at a time
  double log_create_s = 0;          ///< the file system makes one log at a time
  double bandwidth_B_per_s = 1e12;  ///< of the file system, for all ranks together
  double pack_log_open_s = 0;       ///< packing opens and indexes each log, alone
  double pack_s_per_ray = 0;        ///< packing: reading, compressing, writing a ray, alone
};

enum class Grain {
  node,      ///< all rays of an active node are one task
  ray,       ///< single rays, handed out in chunks
  increment  ///< a ray may change rank after every increment: the finest that a path from rest allows
};
enum class Order { stored, longest_first };

struct Policy {
  Grain grain = Grain::ray;
  Order order = Order::stored;  ///< longest first: costs known beforehand, the best that can be hoped for
  /// Guided chunks of rays: remaining / (divisor * ranks), rounded up; 0: one by one.
  double guided_divisor = 2;
  /// A chunk ends with its node.
  bool one_node = false;
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

struct Schedule {
  int ranks = 1;
  double wall_s = 0;
  double solved_s = 0;  ///< when the last rank ran out of tasks
  CoreSeconds spent;
};

/// Simulates one run. Events at equal times are served in the order of ranks, so the result is reproducible.
/// @pre ranks >= 1, all costs finite and not negative
Schedule simulate(const RayWork& work, const MachineCosts& machine, const Policy& policy, int ranks);

}  // namespace phynness
