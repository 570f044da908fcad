// Claim: in simple cases the simulation of a precompute agrees with a calculation by hand in all parts of the time.
// Times are multiples of powers of two, so that sums are exact and need no tolerance unless stated.
#include <gtest/gtest.h>

#include <phynness/planning/scaling_curve.hpp>
#include <random>

namespace phynness {
namespace {

/// n_nodes x rays_per_node rays.
RayWork equal_rays(int n_nodes, int rays_per_node, double seconds) {
  RayWork work;
  for (int n = 0; n < n_nodes; ++n)
    for (int r = 0; r < rays_per_node; ++r) work.rays.push_back({n, r});
  work.seconds.assign(work.rays.size(), seconds);
  return work;
}

TEST(Schedule, equal_tasks_fill_all_ranks) {
  const auto work = equal_rays(80, 1, 0.5);
  for (const int ranks : {1, 2, 4, 8, 80}) {
    const auto s = simulate(work, {}, ranks);
    EXPECT_EQ(s.wall_s, 40.0 / ranks) << ranks;
    EXPECT_EQ(s.spent.tail, 0) << ranks;
    EXPECT_EQ(s.spent.solving, 40) << ranks;
  }
}

TEST(Schedule, fewer_tasks_than_ranks_leave_ranks_idle) {
  const auto s = simulate(equal_rays(3, 1, 2), {}, 5);
  EXPECT_EQ(s.wall_s, 2);
  EXPECT_EQ(s.spent.tail, 4);  // two ranks, two seconds
}

TEST(Schedule, one_long_ray_at_the_end_makes_a_tail) {
  auto work = equal_rays(9, 1, 1);
  work.seconds[8] = 4;
  // Eight short ones on two ranks end at 4, the long one then takes until 8.
  EXPECT_EQ(simulate(work, {}, 2).wall_s, 8);
  EXPECT_EQ(simulate(work, {}, 2).spent.tail, 4);
}

TEST(Schedule, tasks_shrink_and_go_to_whoever_is_free) {
  MachineCosts machine;
  machine.fetch_latency_s = 0.25;
  // One rank: the first task takes all rays of the node; then one more question finds nothing.
  EXPECT_EQ(simulate(equal_rays(1, 8, 1), machine, 1).spent.fetching, 0.5);
  // Four nodes of two, a task ends with its node: four tasks and the last question.
  EXPECT_EQ(simulate(equal_rays(4, 2, 1), machine, 1).spent.fetching, 1.25);
  // Eight rays on two ranks, a half of what is left each time: 4, 2, 1, 1. The first rank has the first four
  // until 4 s, the second one takes the others, and each asks once in vain.
  const auto s = simulate(equal_rays(1, 8, 1), {}, 2);
  EXPECT_EQ(s.wall_s, 4);
  EXPECT_EQ(simulate(equal_rays(1, 8, 1), machine, 2).spent.fetching, 6 * 0.25);
  const TakenTask expected[] = {{0, 4, 0}, {4, 6, 1}, {6, 7, 1}, {7, 8, 1}};
  ASSERT_EQ(s.tasks.size(), std::size(expected));
  for (std::size_t t = 0; t < s.tasks.size(); ++t) {
    EXPECT_EQ(s.tasks[t].first, expected[t].first) << t;
    EXPECT_EQ(s.tasks[t].end, expected[t].end) << t;
    EXPECT_EQ(s.tasks[t].rank, expected[t].rank) << t;
  }
}

TEST(Schedule, ranks_that_share_a_node_set_it_up_each) {
  MachineCosts machine;
  machine.node_setup_s = 0.5;
  // Four rays on two ranks: tasks of 2, 1, 1. The second rank keeps the node for its second task.
  const auto shared = simulate(equal_rays(1, 4, 1), machine, 2);
  EXPECT_EQ(shared.wall_s, 2.5);
  EXPECT_EQ(shared.spent.node_setup, 1);
  EXPECT_EQ(shared.spent.tail, 0);
  EXPECT_EQ(simulate(equal_rays(1, 4, 1), machine, 1).spent.node_setup, 0.5);
  // A ray that is not asked for touches no node.
  EXPECT_EQ(simulate(equal_rays(3, 4, 0), machine, 1).wall_s, 0);
}

TEST(Schedule, the_file_system_serves_one_at_a_time) {
  auto work = equal_rays(4, 1, 1);
  work.bytes_per_ray = 100;
  MachineCosts machine;
  machine.bandwidth_B_per_s = 200;  // half a second a record
  machine.log_create_s = 0.25;
  const auto s = simulate(work, machine, 4);
  // Ranks start at 0.25, 0.5, 0.75, 1; solve until 1.25 ... 2; records end at 1.75, 2.25, 2.75, 3.25.
  EXPECT_EQ(s.solved_s, 3.25);
  EXPECT_EQ(s.spent.start, 2.5);
  EXPECT_EQ(s.spent.writing, 0.5 + 0.75 + 1 + 1.25);
}

TEST(Schedule, every_rank_makes_its_records_itself) {
  MachineCosts machine;
  machine.log_s_per_ray = 0.5;
  const auto s = simulate(equal_rays(4, 1, 1), machine, 4);
  EXPECT_EQ(s.wall_s, 1.5);
  EXPECT_EQ(s.spent.writing, 2);
}

TEST(Schedule, the_counter_serves_one_at_a_time) {
  MachineCosts machine;
  machine.fetch_service_s = 0.125;
  const auto s = simulate(equal_rays(2, 1, 1), machine, 2);
  // Served at 0.125 and 0.25; solved at 1.125 and 1.25; told that nothing is left at 1.25 and 1.375.
  EXPECT_EQ(s.solved_s, 1.375);
  EXPECT_EQ(s.spent.fetching, 0.125 + 0.25 + 0.125 + 0.125);
  EXPECT_EQ(s.spent.tail, 0.125);
}

TEST(Schedule, start_and_packing_are_not_shared) {
  MachineCosts machine;
  machine.launch_s = 1;
  machine.start_s = 2;
  machine.pack_s_per_ray = 0.25;
  machine.pack_log_open_s = 0.5;
  const auto work = equal_rays(8, 1, 4);
  const auto one = simulate(work, machine, 1);
  EXPECT_EQ(one.wall_s, 3 + 32 + 2 + 0.5);
  const auto four = simulate(work, machine, 4);
  EXPECT_EQ(four.wall_s, 3 + 8 + 2 + 2);
  EXPECT_EQ(four.spent.packing, 16);
  EXPECT_EQ(efficiency(one, four), 37.5 / 60);
  EXPECT_EQ(limited_by(one, four, work, machine), Limit::packing);
  EXPECT_EQ(limited_by(one, one, work, machine), Limit::nothing);
}

TEST(Schedule, every_core_second_is_accounted_for) {
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> cost(-1, 0.7);
  RayWork work;
  for (int ray = 0; ray < 500; ++ray) {
    work.rays.push_back({ray / 26, ray % 26});
    work.seconds.push_back(ray % 7 == 0 ? 0 : cost(random));
  }
  work.bytes_per_ray = 4e4;
  MachineCosts machine{0.1, 0.5, 0.02, 1e-5, 1e-6, 1e-3, 1e-4, 1e7, 1e-3, 2e-3};
  for (const int ranks : {1, 7, 100, 1000}) {
    const auto s = simulate(work, machine, ranks);
    // Rounding of some thousand additions.
    EXPECT_NEAR(s.spent.sum(), ranks * s.wall_s, 1e-9 * ranks * s.wall_s) << ranks;
    EXPECT_NEAR(s.spent.solving, work.total_seconds(), 1e-9 * work.total_seconds());
    EXPECT_GE(s.wall_s, std::max(work.longest_seconds(), work.total_seconds() / ranks));
    std::int64_t next = 0;
    for (const auto& task : s.tasks) {
      EXPECT_EQ(task.first, next);
      next = task.end;
    }
    EXPECT_EQ(next, 500);
  }
}

TEST(ScalingCurve, ranks_at_ninety_percent_where_it_is_known) {
  // 1000 equal rays of 1000 nodes take ceil(1000 / N) rounds on N ranks.
  const auto work = equal_rays(1000, 1, 1);
  const auto at = [](int n) { return 1000.0 / (n * ((1000 + n - 1) / n)); };
  const int ranks = ranks_at_efficiency(0.9, work, {}, 10000);
  EXPECT_GE(at(ranks), 0.9);
  EXPECT_LT(at(ranks + 1), 0.9);
  // Perfect work has no limit but the given one; a start as long as the work has it at once.
  EXPECT_EQ(ranks_at_efficiency(0.9, equal_rays(64, 1, 1), {}, 2), 2);
  MachineCosts slow;
  slow.start_s = 1000;
  EXPECT_EQ(ranks_at_efficiency(0.9, work, slow, 10000), 1);
}

TEST(ScalingCurve, what_ranks_wait_for_at_the_end_is_told_apart) {
  const auto limit = [](const RayWork& work, int ranks) {
    return limited_by(simulate(work, {}, 1), simulate(work, {}, ranks), work, {});
  };
  EXPECT_EQ(limit(equal_rays(4, 1, 1), 8), Limit::n_rays);
  // Five rays of 1 s on four ranks: two rounds, the second for one rank.
  EXPECT_EQ(limit(equal_rays(5, 1, 1), 4), Limit::last_rays);
  auto work = equal_rays(9, 1, 1);
  work.seconds[8] = 8;
  EXPECT_EQ(limit(work, 4), Limit::longest_ray);
}

}  // namespace
}  // namespace phynness
