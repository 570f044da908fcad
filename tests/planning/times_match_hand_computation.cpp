// Claim: the wall time of a plan is the one computed by hand where it is simple: shared work, a long ray, few rays.
// Times are multiples of powers of two, so that sums are exact and need no tolerance.
#include <gtest/gtest.h>

#include <phynness/precompute/planning.hpp>

namespace phynness {
namespace {

TEST(RunTime, ranks_share_rays_and_packing_but_not_the_start) {
  const RunCosts costs{.start_s = 6, .ray_s = 0.5, .longest_s = 0.5, .packing_s = 4, .rays = 80, .nodes = 8};
  EXPECT_EQ(wall_seconds(costs, 1), 6 + 40 + 4);
  EXPECT_EQ(wall_seconds(costs, 8), 6 + 5 + 0.5);
  // One rank takes 50 s. Nine spend 98.5 s, less than twice as much, and ten 105 s, more than twice as much.
  EXPECT_EQ(max_useful_ranks(costs), 9);
}

TEST(RunTime, a_node_is_packed_by_one_rank) {
  const RunCosts costs{.packing_s = 4, .nodes = 8};
  EXPECT_EQ(wall_seconds(costs, 16), 0.5);
}

TEST(RunTime, the_longest_ray_is_solved_by_one_rank) {
  const RunCosts costs{.ray_s = 1, .longest_s = 4, .rays = 16, .nodes = 2};
  EXPECT_EQ(wall_seconds(costs, 4), 4);
  EXPECT_EQ(wall_seconds(costs, 16), 4);
  EXPECT_EQ(max_useful_ranks(costs), 8);  // 8 x 4 s are twice 16 s
}

TEST(RunTime, ranks_that_share_a_node_set_it_up_each) {
  const RunCosts costs{.ray_s = 1, .longest_s = 1, .setup_s = 0.5, .rays = 4, .nodes = 1};
  EXPECT_EQ(wall_seconds(costs, 1), 4.5);
  EXPECT_EQ(wall_seconds(costs, 2), 2.5);
}

TEST(RunTime, no_more_ranks_than_rays_are_of_use) {
  EXPECT_EQ(max_useful_ranks({.ray_s = 1, .longest_s = 1, .rays = 3, .nodes = 1}), 3);
}

}  // namespace
}  // namespace phynness
