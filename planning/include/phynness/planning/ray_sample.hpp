// Which few rays stand for all of a scene, and what they say about all.
#pragma once

#include <cstdint>
#include <phynness/formats/mesh.hpp>
#include <phynness/planning/schedule.hpp>
#include <vector>

namespace phynness {

struct RayChoice {
  std::int32_t active = 0, direction = 0;  ///< indices, as in Ray
};

/// About `wanted` rays: runs of neighbouring directions at nodes spread over the active ones. Nodes: one at
/// random from each of equally long stretches of a space-filling curve through them, so that every region
/// counts by its number of nodes. Directions: each run goes on where the last one ended, so that all come
/// equally often; neighbours, because that is how precompute solves them.
/// @param active_points  n_active x 3, positions in any unit
/// @param requested      n_active x n_directions flags; only such rays are chosen
/// @return in the database's order; a run per node; empty if nothing is requested
std::vector<RayChoice> choose_rays(const Points& active_points, const std::vector<char>& requested,
                                   std::size_t n_directions, std::size_t wanted, std::uint64_t seed);

/// What the chosen rays cost.
struct RaySample {
  std::vector<RayChoice> rays;
  int increments = 1;
  std::vector<double> seconds;  ///< n_rays x increments: CPU time [s]

  double mean_ray_seconds() const;
  /// Standard error of the mean over the mean, nodes taken as independent draws; 0 for a single node.
  double relative_error() const;
};

/// All rays of the scene: a requested ray costs what one of the sample did, all of them equally often, dealt
/// at random; the others cost nothing.
RayWork work_like(const RaySample& sample, const std::vector<char>& requested, std::size_t n_directions,
                  std::uint64_t seed);

}  // namespace phynness
