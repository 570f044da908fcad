// Claim: the sample of a plan covers active nodes and directions evenly and is the same for the same seed, and
// estimates keep the mean of the sample.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <phynness/precompute/planning.hpp>

namespace phynness {
namespace {

Points line_of_points(int n) {
  Points points = Points::Zero(n, 3);
  for (int i = 0; i < n; ++i) points(i, 0) = i;
  return points;
}

TEST(RaySample, every_region_and_every_direction_counts_equally) {
  const auto rays = choose_rays(line_of_points(130), Points(0, 3), std::vector<char>(130 * 26, 1), 26, 52, 3);
  ASSERT_EQ(rays.size(), 52u);
  std::map<int, int> per_tenth, per_direction;
  for (const auto& ray : rays) {
    ++per_tenth[ray.active / 10];
    ++per_direction[ray.direction];
  }
  EXPECT_EQ(per_tenth.size(), 13u);  // 26 runs of 2, one in each stretch of 5 nodes
  for (const auto& [tenth, n] : per_tenth) EXPECT_EQ(n, 4) << tenth;
  EXPECT_EQ(per_direction.size(), 26u);
  for (const auto& [direction, n] : per_direction) EXPECT_EQ(n, 2) << direction;
  for (std::size_t i = 1; i < rays.size(); ++i)
    EXPECT_TRUE(rays[i - 1].active < rays[i].active ||
                (rays[i - 1].active == rays[i].active && rays[i - 1].direction < rays[i].direction));
}

TEST(RaySample, the_seed_decides) {
  const auto choose = [](std::uint64_t seed) {
    std::vector<std::pair<int, int>> rays;
    for (const auto& r : choose_rays(line_of_points(500), Points(0, 3), std::vector<char>(500 * 26, 1), 26, 48, seed))
      rays.emplace_back(r.active, r.direction);
    return rays;
  };
  EXPECT_EQ(choose(5), choose(5));
  EXPECT_NE(choose(5), choose(6));
}

TEST(RaySample, small_scenes_and_rays_not_requested) {
  // Two nodes, 26 directions: the wanted number comes from longer runs. Three rays in all: all of them.
  EXPECT_EQ(choose_rays(line_of_points(2), Points(0, 3), std::vector<char>(52, 1), 26, 40, 1).size(), 40u);
  EXPECT_EQ(choose_rays(line_of_points(1), Points(0, 3), std::vector<char>(3, 1), 3, 40, 1).size(), 3u);
  std::vector<char> half(20 * 26, 0);
  for (std::size_t i = 0; i < half.size(); i += 2) half[i] = 1;
  const auto rays = choose_rays(line_of_points(20), Points(0, 3), half, 26, 40, 1);
  EXPECT_EQ(rays.size(), 40u);
  for (const auto& r : rays) EXPECT_EQ(r.direction % 2, 0);
  EXPECT_TRUE(choose_rays(line_of_points(20), Points(0, 3), std::vector<char>(20 * 26, 0), 26, 40, 1).empty());
}

TEST(RaySample, nodes_that_are_asked_for_nothing_take_no_part) {
  // Of 20 nodes one is solved, whichever place the draw falls on.
  std::vector<char> one(20 * 26, 0);
  std::fill(one.begin() + 13 * 26, one.begin() + 14 * 26, char{1});
  for (std::uint64_t seed = 0; seed < 8; ++seed)
    for (const std::size_t wanted : {1, 16}) {
      const auto rays = choose_rays(line_of_points(20), Points(0, 3), one, 26, wanted, seed);
      EXPECT_EQ(rays.size(), std::max<std::size_t>(wanted, 2));  // they come in pairs
      for (const auto& ray : rays) EXPECT_EQ(ray.active, 13);
    }
  // A node with half the rays weighs half as much.
  std::vector<char> some(20 * 26, 1);
  for (std::size_t i = 10 * 26; i < some.size(); i += 2) some[i] = 0;
  double weight = 0, cost = 0;
  for (const auto& ray : choose_rays(line_of_points(20), Points(0, 3), some, 26, 40, 1)) {
    weight += ray.weight;
    cost += ray.weight * (ray.active < 10 ? 1 : 4);
  }
  EXPECT_NEAR(cost / weight, 2, 1e-12);  // 260 rays cost 1 and 130 cost 4; rounding
}

TEST(RaySample, nodes_near_fixed_ones_come_more_often_and_weigh_less) {
  // Distances 1 ... 400 from the only fixed point: the nearest tenth holds 4.28 / 6.57 of the sum of 1 / distance.
  Points points = line_of_points(400);
  points.col(0).array() += 1;
  const auto rays = choose_rays(points, Points::Zero(1, 3), std::vector<char>(400 * 26, 1), 26, 96, 11);
  double near = 0, weight = 0, cost = 0;
  for (const auto& ray : rays) {
    near += ray.active < 40;
    weight += ray.weight;
    cost += ray.weight * (ray.active < 40 ? 10 : 1);
  }
  EXPECT_NEAR(near / static_cast<double>(rays.size()), 4.28 / 6.57, 0.1);  // rays drawn twice count once
  // The mean cost is 1.9. Standard error with 48 nodes: 9 %; drawn evenly it would be 20 %.
  EXPECT_NEAR(cost / weight, 1.9, 0.2 * 1.9);
}

TEST(RaySample, its_mean_is_weighted) {
  std::vector<RayChoice> rays{{0, 0, 1}, {0, 1, 1}, {4, 2, 1}, {4, 3, 1}};
  EXPECT_EQ(costs_of(rays, {2, 4, 6, 8}).mean_s, 5);
  EXPECT_EQ(costs_of(rays, {2, 4, 6, 8}).longest_s, 8);
  // The second node stands for twice as many rays: (2 + 4 + 2 (6 + 8)) / 6.
  rays[2].weight = rays[3].weight = 2;
  EXPECT_NEAR(costs_of(rays, {2, 4, 6, 8}).mean_s, 34.0 / 6, 1e-15 * 10);  // rounding
}

TEST(RaySample, a_few_nodes_have_no_standard_error) {
  std::vector<RayChoice> rays;
  std::vector<double> seconds;
  for (int node = 0; node < 16; ++node)
    for (int direction = 0; direction < 2; ++direction) {
      rays.push_back({node, direction, 1});
      seconds.push_back(node % 2 == 0 ? 3 : 7);
    }
  // Means of 16 nodes, eight times 3 and eight times 7: a standard deviation of 2 sqrt(16 / 15), over
  // sqrt(16) and the mean of 5. The tolerance is the rounding of some sums and a root.
  const auto error = costs_of(rays, seconds).relative_error;
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(*error, 2 * std::sqrt(16.0 / 15) / 4 / 5, 1e-15);
  for (const std::size_t nodes : {14, 2, 1}) {
    rays.resize(2 * nodes);
    seconds.resize(2 * nodes);
    EXPECT_FALSE(costs_of(rays, seconds).relative_error.has_value()) << nodes;
  }
}

}  // namespace
}  // namespace phynness
