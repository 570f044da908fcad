// Which few rays stand for all of a scene, and what they say about all.
#pragma once

#include <cstdint>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/planning/schedule.hpp>
#include <vector>

namespace phynness {

struct RayChoice {
  std::int32_t active = 0, direction = 0;  ///< indices, as in Ray
  double weight = 1;                       ///< for how many rays it stands, up to a common factor
};

/// About `wanted` rays: pairs of neighbouring directions at nodes that are drawn systematically with a
/// probability inverse to their distance from the fixed nodes, which is where solves are long (measured on a
/// liver: the logarithms of cost and distance correlate with -0.78, and the error of the mean is half that of
/// nodes drawn evenly). Directions go on where the last pair ended, so that all come equally often.
/// @param active_points, fixed_points  n x 3, positions in the same unit; without fixed ones nodes are drawn
/// evenly
/// @param requested  n_active x n_directions flags; only such rays are chosen
/// @return in the database's order, no ray twice; empty if nothing is requested
std::vector<RayChoice> choose_rays(const Points& active_points, const Points& fixed_points,
                                   const std::vector<char>& requested, std::size_t n_directions, std::size_t wanted,
                                   std::uint64_t seed);

/// What the chosen rays cost.
struct RaySample {
  std::vector<RayChoice> rays;
  std::vector<double> seconds;  ///< CPU time of each ray [s]

  double mean_ray_seconds() const;  ///< weighted
  /// Standard error of the mean over the mean, nodes taken as independent draws. Too small if the sample has
  /// missed rare long rays.
  /// @return nothing for fewer than `fewest_nodes` nodes
  std::optional<double> relative_error() const;
  /// A standard error from n draws is itself uncertain by about 1 / sqrt(2 (n - 1)) of its value: 19 % with
  /// 15 nodes, which are 30 rays as rays are chosen in pairs; 71 % with two.
  static constexpr std::size_t fewest_nodes = 15;
};

/// A requested ray costs what one of the sample did, all of them equally often, dealt at random; the others
/// cost nothing.
/// @param rays       those that are solved or recorded, as rays_left() orders them
/// @param requested  n_active x n_directions flags
RayWork work_like(const RaySample& sample, const std::vector<RayIndex>& rays, const std::vector<char>& requested,
                  std::size_t n_directions, std::uint64_t seed);

}  // namespace phynness
