// Claim: a solve of `check` that does not end is given up when the time is over, at its next iteration; the probes
// before it stay complete, and the others are counted.
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

  // The clock counts how often it is read, which every iteration of a solve does. From some reading on it is slow.
  std::int64_t reads = 0, first_slow = 1'000'000;
  DiscretizationOptions options;
  options.probes = 2;
  options.reference = Variant::half_size;
  options.seconds = 1e5;
  options.clock = [&] {
    ++reads;
    return static_cast<double>(reads) + 1e5 * static_cast<double>(std::max(reads - first_slow, std::int64_t{0}));
  };
  const auto all = check_discretization(block.scene, block.mesh, block.sets, options);
  EXPECT_EQ(all.ratios(1).n, 2);
  EXPECT_EQ(all.left_out, 0);
  EXPECT_LT(all.sufficient_s, options.seconds);

  first_slow = reads - 5;  // in the last solve
  reads = 0;
  const auto one = check_discretization(block.scene, block.mesh, block.sets, options);
  EXPECT_EQ(one.ratios(1).n, 1);
  EXPECT_EQ(one.left_out, 1);
  EXPECT_FALSE(one.interrupted);
  EXPECT_GT(one.sufficient_s, options.seconds);
}

}  // namespace
}  // namespace phynness::test
