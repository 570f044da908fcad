// Closed, non-radial paths of the tool, solved with warm starts, to find states that depend on the path.
#pragma once

#include "bodies.hpp"

namespace phynness::robustness {

struct PathTally {
  int paths = 0, open = 0;          ///< open: the end was not reached
  int points = 0, indefinite = 0;   ///< reached points, and those with negative pivots
  int compared = 0, different = 0;  ///< compared with the radial solution; different: by more than `same_force`
  int radial_higher = 0;            ///< different points at which the radial state has the higher energy
  int finer_agrees = 0;           ///< different points at which four times the increments lead to the state of the path
  double largest_difference = 0;  ///< |F path - F radial| / |F radial|
  double largest_gap = 0;         ///< after the loop, |F end - F begin| / |F begin|
  std::int32_t worst_node = -1;   ///< node and displacement with the largest difference
  Vec3 worst_displacement_m{};
  double largest_work = 0;  ///< |closed integral of F . dd| / largest energy on the path
};
/// Two solutions of a state with a tolerance of 1e-8 of the reactions differ by this tolerance times the norm of the
/// sensitivities.
inline constexpr double same_force = 1e-6;

/// For each node two circles of `n_points` points at the distance `radius_m` from the node at rest: one in a plane
/// through the inward normal (push, slide, pull, slide), and one around the inward normal at 45 degrees. Every
/// `n_points / 8`-th point is compared with the radial solution.
PathTally walk_circles(const Body& body, const std::vector<std::int32_t>& nodes, double radius_m, int n_points);

}  // namespace phynness::robustness
