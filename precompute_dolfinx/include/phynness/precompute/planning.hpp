// A sample of rays that represents all rays of a scene, and the prediction of the cost of a run from this sample.
#pragma once

#include <cstdint>
#include <optional>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

struct RayChoice {
  std::int32_t active = 0, direction = 0;  ///< indices, as in Ray
  double weight = 1;                       ///< number of rays that it represents, up to a common factor
};

/// About `wanted` rays: pairs of neighbouring directions at nodes that are drawn systematically with a probability
/// inverse to their distance from the fixed nodes. Solves near fixed nodes take longer (on a liver the logarithms of
/// cost and distance have a correlation of -0.78, and the error of the mean is half of that with equal probabilities).
/// The directions of a pair follow those of the previous pair, so that all directions occur equally often.
/// @param active_points, fixed_points  n x 3, positions in the same unit; without fixed points all nodes have the same
///   probability
/// @param requested   n_active x n_directions flags; only these rays are selected
/// @return in the order of the database, no ray twice; empty if nothing is requested
std::vector<RayChoice> choose_rays(const Points& active_points, const Points& fixed_points,
                                   const std::vector<char>& requested, std::size_t n_directions, std::size_t wanted,
                                   std::uint64_t seed);

struct RayCosts {
  double mean_s = 0, longest_s = 0;  ///< weighted mean, and maximum, over the rays
  /// Relative standard error of the mean, with nodes as independent draws. It is underestimated if the sample misses
  /// rare long rays. Empty for fewer than `fewest_nodes` nodes.
  std::optional<double> relative_error;
  /// The standard error of n draws has itself a relative uncertainty of about 1 / sqrt(2 (n - 1)): 19 % with 15 nodes,
  /// which are 30 rays because rays are selected in pairs; 71 % with two nodes.
  static constexpr std::size_t fewest_nodes = 15;
};
/// @param seconds  CPU time of each ray [s]. @pre there is a ray
RayCosts costs_of(const std::vector<RayChoice>& rays, const std::vector<double>& seconds);

/// CPU times of the parts of a run.
struct RunCosts {
  double start_s = 0;    ///< start of each rank: scene, mesh, discretization
  double ray_s = 0;      ///< mean time of a ray
  double longest_s = 0;  ///< time of the longest ray
  double setup_s = 0;    ///< preparation of a node by a rank
  double packing_s = 0;  ///< packing of all nodes, which the ranks share
  std::int64_t rays = 0, nodes = 0;
};

/// The predicted wall time, start + max((rays ray + (nodes + ranks - 1) setup) / ranks, longest + setup) + packing /
/// min(ranks, nodes), without reading, writing and launching. At the end ranks share nodes and may wait for a long ray.
double wall_seconds(const RunCosts& costs, int ranks);

/// The largest number of ranks, at most one per ray, with a parallel efficiency of at least one half.
int max_useful_ranks(const RunCosts& costs);

}  // namespace phynness
