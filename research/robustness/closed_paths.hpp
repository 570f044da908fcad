// Closed, non-radial paths of the tool, followed with warm starts: does the state depend on how it was reached?
#pragma once

#include "bodies.hpp"

namespace phynness::robustness {

struct PathTally {
  int paths = 0, open = 0;          ///< open: could not be walked to the end
  int points = 0, indefinite = 0;   ///< walked to, and of them with negative pivots
  int compared = 0, different = 0;  ///< with the radial answer; different: by more than `same_force`
  int radial_higher = 0;            ///< of the different ones, those where the radial state has the higher energy
  int finer_agrees = 0;             ///< and those where four times the increments lead to the walked state
  double largest_difference = 0;    ///< |F walked - F radial| / |F radial|
  double largest_gap = 0;           ///< after the loop, |F end - F begin| / |F begin|
  std::int32_t worst_node = -1;     ///< where the difference is largest, and at which displacement
  Vec3 worst_displacement_m{};
  double largest_work = 0;  ///< |closed integral of F . dd| / largest energy on the way
};
/// Two solves of one state that stop at 1e-8 of the reactions differ by that times the norm of the
/// sensitivities.
inline constexpr double same_force = 1e-6;

/// For each node two circles of `n_points` points at distance `radius_m` from where the node is at rest: one
/// in a plane through the inward normal (push, slide, pull, slide), one round the inward normal at 45 degrees
/// (a stirring tool). Every `n_points / 8`-th point is compared with the radial answer.
PathTally walk_circles(const Body& body, const std::vector<std::int32_t>& nodes, double radius_m, int n_points);

}  // namespace phynness::robustness
