// Claims: a solve of `check` that does not end is given up when the time is over, at its next iteration; the probes
// before it stay complete, and the others are counted. A finer solution that does not fit into the memory is refused
// before it begins, and finer bodies at rest are left out with the reason. Places near fixed nodes have their share of
// the area in each beginning of the rays, also if it is all. A check ends when its mean is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/validation/discretization.hpp>

#include "messages.hpp"
#include "probe_block.hpp"

namespace phynness::test {
namespace {

ProbeBlock two_places() {
  auto block = probe_block({law_named("neo-hookean"), element_named("p1-p1")}, 10, {2, 2, 2});
  block.sets.active.push_back(nearest_node(block.mesh, {0, 0, block_size_m[2]}));
  block.scene.probe.increments = 2;
  block.scene.probe.max_displacement_m = 0.005;
  return block;
}

TEST(Check, SaysWhichSolutionsDoNotFitIntoTheMemory) {
  const auto block = two_places();
  DiscretizationOptions options;
  options.probes = 1;
  options.available_bytes = [] { return 1e8; };
  expect_names(message_of([&] { check_discretization(block.scene, block.mesh, block.sets, options); }),
               {"does not fit into the memory", "0.15 GB of memory are needed, 0.10 GB", "check_probes = 0"});
  // 27 nodes have 98 edges: 402 unknowns of Taylor-Hood, and 2,312 with cells of half the size.
  options.available_bytes = [] { return 1.52e8; };
  const auto report = check_discretization(block.scene, block.mesh, block.sets, options);
  EXPECT_NE(
      report.at_rest.skipped_reason.find("the size of the cells (cells of half the size: 0.16 GB of memory are needed"),
      std::string::npos)
      << report.at_rest.skipped_reason;
  const auto distance = report.distance(block.scene);
  EXPECT_EQ(distance.probes, 1);
  EXPECT_GT(distance.element_at_rest.places, 0);
  EXPECT_EQ(distance.cells_at_rest.places, 0);
  EXPECT_EQ(distance.of_reference.places, 0);
}

TEST(Check, TakesPlacesNearFixedNodesByTheirShareOfTheArea) {
  auto block = probe_block({law_named("neo-hookean"), element_named("p1-p1")}, 10, {6, 6, 6});
  NodeList& active = block.sets.active;
  active.clear();
  for (const auto node : surface_nodes(block.mesh.surface))
    if (block.mesh.nodes(node, 2) > 0) active.push_back(node);
  const auto header = database_header(block.scene, block.mesh, block.sets);
  const std::vector<char> requested(active.size() * header.directions.size(), 1);
  // Rows of nodes are 10 mm apart. Of the walls, 36 mm around, the rows at 10 and 20 mm have 10 mm each, the upper one
  // has 5 mm.
  const double radius_m = 0.025, around_m = 0.36;
  const auto [rays, share] = choose_checked_rays(header, requested, radius_m, 30);
  EXPECT_NEAR(share, 0.02 * around_m / (0.055 * around_m + 0.008), 1e-12);
  double near = 0;
  ASSERT_EQ(rays.size(), 30u);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(rays[i].near_fixed, block.mesh.nodes(active[static_cast<std::size_t>(rays[i].active)], 2) < radius_m);
    near += rays[i].near_fixed ? 1 : 0;
    EXPECT_NEAR(near, share * static_cast<double>(i + 1), 1.5) << i;
  }
  const auto all = choose_checked_rays(header, requested, 0.07, 1000);
  EXPECT_EQ(all.near_share, 1);
  EXPECT_EQ(all.rays.size(), active.size());
}

TEST(Check, EndsWhenItsMeanIsKnown) {
  const auto probes = [](std::initializer_list<double> errors, std::size_t near = 0) {
    std::vector<CheckedProbe> all;
    for (const double error : errors)
      all.push_back({.near_fixed = all.size() < near,
                     .own = {{Status::converged}, {{1 + error, 0, 0}}},
                     .finer = {{Status::converged}, {{1, 0, 0}}}});
    return all;
  };
  EXPECT_FALSE(is_known(probes({0.05, 0.05, 0.05}), 0)) << "too few";
  EXPECT_TRUE(is_known(probes({0.05, 0.05, 0.05, 0.05}), 0));
  EXPECT_FALSE(is_known(probes({0.05, 0.05, 0.05, 0.05}, 1), 0.2)) << "one near fixed nodes";
  EXPECT_TRUE(is_known(probes({0.05, 0.05, 0.05, 0.05}, 1), 0.1));
  EXPECT_FALSE(is_known(probes({0, 0, 0, 0.2}), 0)) << "the standard error is the mean";
  EXPECT_TRUE(is_known(probes({0, 0, 0, 0.03}), 0)) << "but below 1 %";
}

// Claim: rows that cost less than the scene are solved before the finer solution, for which time is kept; where only
// the scene was compared none is chosen.
TEST(Check, TradesCheapRowsFirst) {
  const auto block = two_places();
  DiscretizationOptions options;
  options.probes = 1;
  options.seconds = 1e6;
  options.clock = [] { return 0.0; };
  std::int64_t solved = 0;
  const auto count = [&](std::int64_t done, std::int64_t) { solved = done; };
  const auto two =
      compare_discretizations(block.scene, block.mesh, block.sets, options, count, [&] { return solved >= 2; });
  const auto& own = *std::ranges::find_if(two.rows, &TradeRow::is_scene);
  EXPECT_GT(own.ray_s, 0);
  EXPECT_EQ(std::ranges::count_if(two.rows, [](const auto& row) { return row.ray_s > 0; }), 2);
  EXPECT_EQ(
      std::ranges::count_if(two.rows, [&](const auto& row) { return row.ray_s > 0 && row.unknowns < own.unknowns; }),
      1);
  EXPECT_EQ(chosen_row(two, 1), nullptr);

  TradeReport report;
  report.rows.resize(2);
  report.rows[0].is_scene = true;
  for (auto& row : report.rows) row.mean = 0.01, row.ray_s = 1, row.rays = 1;
  report.rows[0].probes = 1;
  EXPECT_TRUE(is_alone(report));
  EXPECT_EQ(chosen_row(report, 0.05), nullptr);
  report.rows[1].probes = 1;
  report.rows[1].ray_s = 0.5;
  EXPECT_EQ(chosen_row(report, 0.05), &report.rows[1]);
  EXPECT_EQ(chosen_row(report, 0.001), nullptr);
}

TEST(Check, OneLongSolveDoesNotTakeAllTime) {
  const auto block = two_places();

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
