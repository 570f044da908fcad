// Selection of a few rays that represent all rays of a scene, and estimates from their costs.
#pragma once

#include <cstdint>
#include <optional>
#include <phynness/formats/mesh.hpp>
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
/// @param requested  n_active x n_directions flags; only these rays are selected
/// @return in the order of the database, no ray twice; empty if nothing is requested
std::vector<RayChoice> choose_rays(const Points& active_points, const Points& fixed_points,
                                   const std::vector<char>& requested, std::size_t n_directions, std::size_t wanted,
                                   std::uint64_t seed);

/// Costs of the selected rays.
struct RaySample {
  std::vector<RayChoice> rays;
  std::vector<double> seconds;  ///< CPU time of each ray [s]

  double mean_ray_seconds() const;  ///< weighted
  /// Standard error of the mean over the mean, with nodes as independent draws. It is too small if the sample contains
  /// none of some rare long rays.
  /// @return empty for fewer than `fewest_nodes` nodes
  std::optional<double> relative_error() const;
  /// The standard error of n draws has itself a relative uncertainty of about 1 / sqrt(2 (n - 1)): 19 % with 15 nodes,
  /// which are 30 rays because rays are selected in pairs; 71 % with two nodes.
  static constexpr std::size_t fewest_nodes = 15;
};

}  // namespace phynness
