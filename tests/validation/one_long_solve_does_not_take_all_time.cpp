// Claim: a solve of `check` that does not end is given up when its share of the time is used up, at its next iteration;
// it leaves the comparison with the other reference and that of the other probe complete.
#include <gtest/gtest.h>

#include <algorithm>
#include <phynness/validation/discretization.hpp>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

TEST(Check, OneLongSolveDoesNotTakeAllTime) {
  auto block = probe_block({law_named("neo-hookean"), element_named("p1-p1")}, 10, {2, 2, 2});
  block.sets.active.push_back(nearest_node(block.mesh, {0, 0, block_size_m[2]}));
  block.scene.probe.increments = 2;
  block.scene.probe.max_displacement_m = 0.005;

  // The clock counts how often it is read, which every iteration of a solve does. In the slow part a reading takes
  // long.
  constexpr std::int64_t n_slow = 6;
  constexpr double slow_s = 1e4;
  std::int64_t reads = 0, first_slow = 1'000'000;
  DiscretizationOptions options;
  options.probes = 2;
  options.seconds = 1e5;
  options.clock = [&] {
    ++reads;
    return static_cast<double>(reads) +
           slow_s * static_cast<double>(std::clamp(reads - first_slow, std::int64_t{0}, n_slow));
  };
  const auto all = check_discretization(block.scene, block.mesh, block.sets, options);
  ASSERT_EQ(all.ratios(Variant::taylor_hood, 1).n, 2);
  ASSERT_EQ(all.ratios(Variant::half_size, 1).n, 2);
  EXPECT_EQ(all.cost(Variant::half_size).left_out, "");
  EXPECT_LT(all.sufficient_s, options.seconds);

  // Now the first solve with cells of half the size needs more than the half of the time that is its share.
  reads = 0;
  first_slow =
      static_cast<std::int64_t>(all.cost(Variant::scene).seconds + all.cost(Variant::taylor_hood).seconds) + 20;
  const auto half = check_discretization(block.scene, block.mesh, block.sets, options);
  EXPECT_EQ(half.ratios(Variant::taylor_hood, 1).n, 2);
  EXPECT_EQ(half.ratios(Variant::half_size, 1).n, 1);
  EXPECT_EQ(half.cost(Variant::half_size).left_out, "time");
  EXPECT_GT(half.cost(Variant::half_size).predicted_s, options.seconds / 2);
  EXPECT_GT(half.sufficient_s, options.seconds);
}

}  // namespace
}  // namespace phynness::test
