// Claim: the simulation of a precompute gives what a pencil gives where a pencil suffices, in every part of
// the account. Times are multiples of powers of two, so sums are exact and need no tolerance, unless said
// otherwise.
#include <gtest/gtest.h>

#include <phynness/planning/scaling_curve.hpp>
#include <random>

namespace phynness {
namespace {

/// n_nodes x rays_per_node rays of one increment.
RayWork equal_rays(int n_nodes, int rays_per_node, double seconds) {
  RayWork work;
  for (int n = 0; n < n_nodes; ++n)
    for (int r = 0; r < rays_per_node; ++r) work.node.push_back(n);
  work.seconds.assign(work.node.size(), seconds);
  return work;
}

Policy one_by_one(Order order = Order::stored) { return {Grain::ray, order, 0, false}; }

TEST(Schedule, equal_tasks_fill_all_ranks) {
  const auto work = equal_rays(10, 8, 0.5);
  for (const int ranks : {1, 2, 4, 8, 80}) {
    const auto s = simulate(work, {}, one_by_one(), ranks);
    EXPECT_EQ(s.wall_s, 40.0 / ranks) << ranks;
    EXPECT_EQ(s.spent.tail, 0) << ranks;
    EXPECT_EQ(s.spent.solving, 40) << ranks;
  }
}

TEST(Schedule, fewer_tasks_than_ranks_leave_ranks_idle) {
  const auto s = simulate(equal_rays(3, 1, 2), {}, one_by_one(), 5);
  EXPECT_EQ(s.wall_s, 2);
  EXPECT_EQ(s.spent.tail, 4);  // two ranks, two seconds
}

TEST(Schedule, one_long_task_makes_a_tail_unless_it_comes_first) {
  auto work = equal_rays(9, 1, 1);
  work.seconds[8] = 4;
  // Eight short ones on two ranks end at 4, the long one then takes until 8; first, it leaves 8 s to 2 ranks:
  // 6 s.
  EXPECT_EQ(simulate(work, {}, one_by_one(), 2).wall_s, 8);
  EXPECT_EQ(simulate(work, {}, one_by_one(), 2).spent.tail, 4);
  EXPECT_EQ(simulate(work, {}, one_by_one(Order::longest_first), 2).wall_s, 6);
}

TEST(Schedule, guided_chunks_shrink_and_pay_the_counter_less) {
  MachineCosts machine;
  machine.fetch_latency_s = 0.25;
  // 8 rays, divisor 1, one rank: the first chunk takes all; then one more question finds nothing.
  const auto work = equal_rays(1, 8, 1);
  EXPECT_EQ(simulate(work, machine, {Grain::ray, Order::stored, 1, false}, 1).spent.fetching, 0.5);
  // Four nodes of two, a chunk ends with its node: four chunks and the last question.
  EXPECT_EQ(simulate(equal_rays(4, 2, 1), machine, {Grain::ray, Order::stored, 1, true}, 1).spent.fetching,
            1.25);
  // 7 rays, divisor 2: chunks of 4, 2, 1 (rounded up).
  EXPECT_EQ(simulate(equal_rays(1, 7, 1), machine, {Grain::ray, Order::stored, 2, false}, 1).spent.fetching,
            1);
  // Divisor 2: chunks of 4, 2, 1, 1.
  EXPECT_EQ(simulate(work, machine, {Grain::ray, Order::stored, 2, false}, 1).spent.fetching, 1.25);
  EXPECT_EQ(simulate(work, machine, one_by_one(), 1).spent.fetching, 2.25);
}

TEST(Schedule, whole_nodes_leave_a_tail_that_rays_do_not) {
  MachineCosts machine;
  machine.node_setup_s = 0.5;
  const auto work = equal_rays(3, 4, 1);
  // Three nodes of 4 s + 0.5 s on two ranks: one rank has two. One by one: 6 rays each, every rank meets each
  // node.
  const auto nodes = simulate(work, machine, {Grain::node, Order::stored, 0, false}, 2);
  EXPECT_EQ(nodes.wall_s, 9);
  EXPECT_EQ(nodes.spent.node_setup, 1.5);
  EXPECT_EQ(nodes.spent.tail, 4.5);
  const auto rays = simulate(work, machine, one_by_one(), 2);
  EXPECT_EQ(rays.wall_s, 7.5);
  EXPECT_EQ(rays.spent.node_setup, 3);
  EXPECT_EQ(rays.spent.tail, 0);
}

TEST(Schedule, a_ray_stays_a_chain_however_fine_the_tasks) {
  RayWork work;
  work.node = {0, 1, 2};
  work.increments = 4;
  work.seconds.assign(12, 1);
  // Three rays of 4 s on two ranks: whole rays 8 s; increments 6 s; on many ranks the longest ray remains.
  EXPECT_EQ(simulate(work, {}, one_by_one(), 2).wall_s, 8);
  EXPECT_EQ(simulate(work, {}, {Grain::increment, Order::longest_first, 0, false}, 2).wall_s, 6);
  EXPECT_EQ(simulate(work, {}, {Grain::increment, Order::longest_first, 0, false}, 100).wall_s, 4);
}

TEST(Schedule, the_file_system_serves_one_at_a_time) {
  auto work = equal_rays(4, 1, 1);
  work.bytes_per_ray = 100;
  MachineCosts machine;
  machine.bandwidth_B_per_s = 200;  // half a second a record
  machine.log_create_s = 0.25;
  const auto s = simulate(work, machine, one_by_one(), 4);
  // Ranks start at 0.25, 0.5, 0.75, 1; solve until 1.25 ... 2; records end at 1.75, 2.25, 2.75, 3.25.
  EXPECT_EQ(s.solved_s, 3.25);
  EXPECT_EQ(s.spent.start, 2.5);
  EXPECT_EQ(s.spent.writing, 0.5 + 0.75 + 1 + 1.25);
}

TEST(Schedule, the_counter_serves_one_at_a_time) {
  MachineCosts machine;
  machine.fetch_service_s = 0.125;
  const auto s = simulate(equal_rays(2, 1, 1), machine, one_by_one(), 2);
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
  const auto one = simulate(work, machine, one_by_one(), 1);
  EXPECT_EQ(one.wall_s, 3 + 32 + 2 + 0.5);
  const auto four = simulate(work, machine, one_by_one(), 4);
  EXPECT_EQ(four.wall_s, 3 + 8 + 2 + 2);
  EXPECT_EQ(four.spent.packing, 16);
  EXPECT_EQ(efficiency(one, four), 37.5 / 60);
  EXPECT_EQ(limited_by(one, four), "packing");
  EXPECT_EQ(limited_by(one, one), "nothing");
}

TEST(Schedule, every_core_second_is_accounted_for) {
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> cost(-1, 0.7);
  RayWork work;
  work.increments = 3;
  for (int ray = 0; ray < 500; ++ray) {
    work.node.push_back(ray / 26);
    for (int i = 0; i < 3; ++i) work.seconds.push_back(cost(random));
  }
  work.bytes_per_ray = 4e4;
  const MachineCosts machine{0.1, 0.5, 0.02, 1e-5, 1e-6, 1e-3, 1e7, 1e-3, 2e-3};
  for (const auto grain : {Grain::node, Grain::ray, Grain::increment})
    for (const auto order : {Order::stored, Order::longest_first})
      for (const int ranks : {1, 7, 100, 1000}) {
        const auto s = simulate(work, machine, {grain, order, 2, true}, ranks);
        // Rounding of some thousand additions.
        EXPECT_NEAR(s.spent.sum(), ranks * s.wall_s, 1e-9 * ranks * s.wall_s) << ranks;
        EXPECT_NEAR(s.spent.solving, work.total_seconds(), 1e-9 * work.total_seconds());
        double longest = 0;
        for (std::size_t ray = 0; ray < work.n_rays(); ++ray)
          longest = std::max(longest, work.ray_seconds(ray));
        EXPECT_GE(s.wall_s, std::max(longest, work.total_seconds() / ranks));
      }
}

TEST(ScalingCurve, ranks_at_ninety_percent_where_it_is_known) {
  // 1000 equal rays take ceil(1000 / N) rounds on N ranks.
  const auto work = equal_rays(1000, 1, 1);
  const auto at = [](int n) { return 1000.0 / (n * ((1000 + n - 1) / n)); };
  const auto most = [](const RayWork& w, const MachineCosts& machine, int limit) {
    return ranks_at_efficiency(0.9, simulate(w, machine, one_by_one(), 1), w, machine, one_by_one(), limit);
  };
  const int ranks = most(work, {}, 10000);
  EXPECT_GE(at(ranks), 0.9);
  EXPECT_LT(at(ranks + 1), 0.9);
  // Perfect work has no limit but the given one; a start as long as the work has it at once.
  EXPECT_EQ(most(equal_rays(64, 1, 1), {}, 2), 2);
  MachineCosts slow;
  slow.start_s = 1000;
  EXPECT_EQ(most(work, slow, 10000), 1);
}

}  // namespace
}  // namespace phynness
