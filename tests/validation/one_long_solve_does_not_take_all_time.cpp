// Claim: `check` makes the cheaper comparison of all probes first, so that a solve of the other comparison that does
// not end leaves it complete.
#include <gtest/gtest.h>

#include <phynness/validation/discretization.hpp>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

TEST(Check, OneLongSolveDoesNotTakeAllTime) {
  auto block = probe_block({law_named("neo-hookean"), element_named("p1-p1")}, 10, {2, 2, 2});
  block.sets.active.push_back(nearest_node(block.mesh, {0, 0, block_size_m[2]}));
  block.scene.probe.increments = 2;
  block.scene.probe.max_displacement_m = 0.005;

  // The clock counts how often it is read, which every iteration of a solve does.
  std::int64_t reads = 0, patient = 1'000'000;
  DiscretizationOptions options;
  options.probes = 2;
  options.seconds = 1e5;
  options.clock = [&] {
    ++reads;
    return static_cast<double>(reads) + (reads > patient ? 1e6 : 0.0);
  };
  const auto all = check_discretization(block.scene, block.mesh, block.sets, options);
  ASSERT_EQ(all.ratios(Variant::taylor_hood, 1).n, 2);
  ASSERT_EQ(all.ratios(Variant::half_size, 1).n, 2);

  // Now the first solve with cells of half the size never ends.
  reads = 0;
  const auto& first = all.cost(Variant::taylor_hood);
  patient = static_cast<std::int64_t>(all.cost(Variant::scene).seconds + first.seconds) + 20;
  const auto half = check_discretization(block.scene, block.mesh, block.sets, options);
  EXPECT_EQ(half.ratios(Variant::taylor_hood, 1).n, 2);
  EXPECT_LE(half.ratios(Variant::half_size, 1).n, 1);
  EXPECT_EQ(half.cost(Variant::half_size).left_out, "time");
  EXPECT_GT(half.cost(Variant::half_size).predicted_s, 0);
}

}  // namespace
}  // namespace phynness::test
