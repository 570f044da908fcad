// Claim: statistics of probes up to R are those of their definition: groups by warning, thirds of the depth, the tenth
// of the nodes with the largest mean error, shares of drawn probes, forces that are off by more than a tenth of their
// own size; probes that the finite elements do not reach are counted and named. The numbers are chosen so that all
// results can be computed mentally; 1e-15 is rounding.
#include <gtest/gtest.h>

#include <phynness/phynness.hpp>
#include <phynness/validation/errors_to_range.hpp>

#include "measure/probe_records.hpp"

namespace phynness {
namespace {

constexpr double tolerance = 1e-15, R = 0.03;

JudgedProbe probe(std::int32_t node, double depth_m, bool flagged, double force, double own, double u) {
  JudgedProbe p;
  p.node = node;
  p.displacement_m = {0, 0, -depth_m};
  p.flagged = flagged;
  p.status = Status::converged;
  p.model = {force, own, {u, 3 * u}};
  p.linear = {2 * force, 2 * own, {2 * u, 6 * u}};
  return p;
}

JudgedProbe lost(std::int32_t node, double depth_m, bool flagged, Status why, double reached_m) {
  auto p = probe(node, depth_m, flagged, 9, 9, 9);  // numbers that must not count
  p.status = why;
  p.reached_m = reached_m;
  return p;
}

std::vector<JudgedProbe> probes() {
  auto beyond = probe(7, 0.04, true, 0.6, 0.6, 0.3);
  beyond.beyond = true;
  return {probe(4, 0.006, false, 0.01, 0.05, 0.001),
          probe(4, 0.010, false, 0.03, 0.11, 0.003),  // 10 mm is still in the first third
          probe(4, 0.015, true, 0.08, 0.20, 0.002),
          probe(7, 0.025, false, 0.20, 0.08, 0.004),
          lost(7, 0.028, false, Status::inverted, 0.011),
          lost(4, 0.029, true, Status::diverged, 0.024),
          beyond};
}

TEST(ErrorsToRange, AreThoseOfTheGroups) {
  const auto e = errors_to_range(probes(), R);
  const auto& all = e.all.overall;
  EXPECT_EQ(all.probes, 6);
  EXPECT_EQ(all.solved, 4);
  EXPECT_EQ(all.share, 1);
  EXPECT_NEAR(all.model.force.mean, 0.08, tolerance);
  EXPECT_NEAR(all.model.force.median, 0.03, tolerance);  // the lower one of the two in the middle
  EXPECT_NEAR(all.model.force.max, 0.20, tolerance);
  EXPECT_NEAR(all.model.wrong, 0.5, tolerance);    // 0.11 and 0.20 of four
  EXPECT_NEAR(all.linear.wrong, 0.75, tolerance);  // and 0.16; 0.10 is not more than a tenth
  EXPECT_EQ(all.model.displacement.n, 8);
  EXPECT_NEAR(all.model.displacement.mean, 0.005, tolerance);
  const auto& unflagged = e.unflagged.overall;
  EXPECT_EQ(unflagged.probes, 4);
  EXPECT_EQ(unflagged.solved, 3);
  EXPECT_NEAR(unflagged.share, 4.0 / 6, tolerance);
  EXPECT_NEAR(unflagged.model.force.mean, 0.08, tolerance);
  EXPECT_NEAR(unflagged.model.wrong, 1.0 / 3, tolerance);
  EXPECT_NEAR(unflagged.linear.force.mean, 0.16, tolerance);
  EXPECT_NEAR(e.flagged.overall.model.force.mean, 0.08, tolerance);
  EXPECT_NEAR(e.flagged.overall.share, 2.0 / 6, tolerance);
  EXPECT_EQ(e.beyond.probes, 1);
  EXPECT_NEAR(e.beyond.model.force.max, 0.6, tolerance);
}

TEST(ErrorsToRange, AreThoseOfDepthAndNodes) {
  const auto e = errors_to_range(probes(), R);
  EXPECT_EQ(e.all.by_depth[0].probes, 2);
  EXPECT_NEAR(e.all.by_depth[0].model.force.mean, 0.02, tolerance);
  EXPECT_EQ(e.all.by_depth[1].probes, 1);
  EXPECT_EQ(e.all.by_depth[2].probes, 3);
  EXPECT_EQ(e.all.by_depth[2].solved, 1);
  EXPECT_NEAR(e.unflagged.by_depth[2].share, 2.0 / 3, tolerance);
  EXPECT_EQ(e.unflagged.by_depth[1].probes, 0);
  EXPECT_EQ(e.worst_nodes, std::vector<std::int32_t>{7});  // 0.20 in the mean, node 4: 0.04
  EXPECT_EQ(e.all.worst_nodes.probes, 2);
  EXPECT_EQ(e.all.worst_nodes.solved, 1);
  EXPECT_NEAR(e.least_unflagged, 0.5, tolerance);  // node 4: two of four are flagged
  ASSERT_EQ(e.nodes.size(), 2U);
  EXPECT_EQ(e.nodes[0].node, 4);
  EXPECT_NEAR(e.nodes[0].force, 0.04, tolerance);
  EXPECT_NEAR(e.nodes[0].force_max, 0.08, tolerance);
  EXPECT_NEAR(e.nodes[0].displacement, 0.004, tolerance);
}

TEST(ErrorsToRange, NameWhatTheFiniteElementsDoNotReach) {
  const auto e = errors_to_range(probes(), R);
  ASSERT_EQ(e.unreached.size(), 2U);
  EXPECT_EQ(sentence(e.unreached[0]),
            "node 7, direction (0.00 0.00 -1.00): finite elements end at 11 mm of 28 mm "
            "(inverted); the runtime does not warn");
  EXPECT_EQ(reasons(e.unreached), "1 diverged (0 without a warning), 1 inverted (1 without a warning)");
  const auto only_lost = errors_to_range({lost(1, 0.02, false, Status::diverged, 0)}, R);
  EXPECT_EQ(only_lost.all.overall.solved, 0);
  EXPECT_EQ(only_lost.all.overall.model.force.n, 0);
  EXPECT_TRUE(std::isnan(only_lost.nodes[0].force));
  EXPECT_TRUE(only_lost.worst_nodes.empty());
  EXPECT_EQ(only_lost.unflagged.overall.share, 1);
  const auto nothing = errors_to_range({}, R);
  EXPECT_EQ(nothing.all.overall.share, 0);
  EXPECT_TRUE(remarks(nothing).empty());
}

TEST(ErrorsToRange, DivideByTheLargestResponseAndAtLeastAHundredthOfIt) {
  LargestResponse largest;
  Points u(2, 3), said(2, 3);
  u << 0, 0, 0.1, 0.004, 0, 0;
  said << 0, 0, 0.3, 0.004, 0.001, 0;
  largest.take({0, 3, 4}, u, {0, 1});
  EXPECT_NEAR(largest.force_N, 5, tolerance);
  EXPECT_NEAR(largest.displacement_m, 0.004, tolerance);  // the first node does not count
  const auto errors = probe_errors({{0, 0, 0.02}, {0, 0, 0.01}, said, u}, largest, {0, 1});
  EXPECT_NEAR(errors.force, 0.002, tolerance);
  EXPECT_NEAR(errors.force_own, 0.2, tolerance);  // 0.01 N of at least 0.05 N
  ASSERT_EQ(errors.displacement.size(), 1U);
  EXPECT_NEAR(errors.displacement[0], 0.25, tolerance);
  EXPECT_TRUE(std::isnan(probe_errors({{}, {}, said, u}, {}, {0, 1}).force));
}

// Claim: a state with a warning is no measure for the others, in any order; among themselves they are.
TEST(ErrorsToRange, DivideByTheLargestResponseWithoutAWarning) {
  const Points none(0, 3);
  for (const int order : {0, 1}) {
    LargestResponse largest;
    for (const int i : {order, 1 - order}) largest.take({0, 0, i == 0 ? 8.0 : 1.0}, none, {}, i == 0);
    EXPECT_EQ(largest.force_N, 1);
  }
  LargestResponse crushed;
  for (const double force : {2.0, 8.0, 3.0}) crushed.take({force, 0, 0}, none, {}, true);
  EXPECT_EQ(crushed.force_N, 8);
}

TEST(ErrorsToRange, AWarningOfTheNodeIsNotOneOfTheState) {
  EXPECT_FALSE(is_flagged(PHN_OK));
  EXPECT_FALSE(is_flagged(PHN_WARNING_INCOMPLETE));
  EXPECT_TRUE(is_flagged(PHN_WARNING_OUTSIDE));
  EXPECT_TRUE(is_flagged(PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE));
  EXPECT_TRUE(is_flagged(PHN_WARNING_UNSETTLED));
}

// Claim: the shares of errors below their bound, by thirds of the depth and quarters of the nodes, and the width of the
// bounds are those of this table. The best constant bound for 5 of 6 errors is the fifth smallest, 0.5.
TEST(BoundCoverage, IsThatOfASheetOfPaper) {
  const std::vector<BoundedError> errors{
      {7, 0.1, 0.1, 0.2, 1}, {7, 0.5, 0.2, 0.2, 1},   // bounds 0.2 of the largest force
      {3, 0.2, 0.3, 0.2, 2}, {3, 0.9, 0.1, 0.4, 2},   // 0.15, one error above its bound
      {5, 1.0, 0.5, 0.9, 1}, {5, 0.6, 0.8, 0.8, 1}};  // 0.85
  const auto c = coverage_of(errors, 1.0);
  EXPECT_EQ(c.states, 6);
  EXPECT_DOUBLE_EQ(c.all, 5.0 / 6);
  EXPECT_DOUBLE_EQ(c.thirds[0], 0.5);
  EXPECT_DOUBLE_EQ(c.thirds[1], 1);
  EXPECT_DOUBLE_EQ(c.thirds[2], 1);
  EXPECT_DOUBLE_EQ(c.quarters[0], 0.5);  // node 3
  EXPECT_DOUBLE_EQ(c.quarters[1], 1);    // node 7
  EXPECT_DOUBLE_EQ(c.quarters[2], 1);    // node 5
  EXPECT_TRUE(std::isnan(c.quarters[3]));
  EXPECT_DOUBLE_EQ(c.width, 2.7 / 6 / 0.5);
  auto weighted = errors;
  for (auto& e : weighted) e.weight = e.node == 3 ? 3 : 1;  // node 3 stands for three: 7 of 10 errors hold
  const auto w = coverage_of(weighted, 1.0);
  EXPECT_DOUBLE_EQ(w.all, 0.7);
  EXPECT_DOUBLE_EQ(w.thirds[0], 0.25);
  EXPECT_DOUBLE_EQ(w.width, (0.4 + 3 * 0.6 + 1.7) / 10 / 0.3);  // errors up to 0.3 have the weight 8
  EXPECT_EQ(coverage_of({}, 1.0).states, 0);
}

// Claim: probes whose bound is at most a fraction of the largest force form a group with a share of all probes up to R;
// probes outside of the trained range and beyond R are in none.
TEST(BoundCoverage, GroupsProbesByTheirBound) {
  std::vector<JudgedProbe> probes(4);
  for (auto& p : probes) {
    p.node = 1;
    p.displacement_m = {0.5, 0, 0};
    p.status = Status::converged;
    p.largest_N = 2;
    p.error_N = 0.01;
    p.bound_N = 0.03;
    p.force_N = 1.4;
  }
  probes[1].bound_N = 0.15;
  probes[2].bound_N = std::numeric_limits<double>::infinity();
  probes[2].flagged = true;
  probes[3].beyond = true;
  const auto e = errors_to_range(probes, 1);
  ASSERT_TRUE(e.bounds);
  EXPECT_EQ(e.bounds->coverage.states, 2);
  ASSERT_EQ(e.bounds->at_most.size(), 3U);
  EXPECT_EQ(e.bounds->at_most[0].errors.probes, 2);  // 0.1: to 0.2 N
  EXPECT_EQ(e.bounds->at_most[1].errors.probes, 1);  // 0.05: to 0.1 N
  EXPECT_EQ(e.bounds->at_most[2].errors.probes, 1);
  EXPECT_DOUBLE_EQ(e.bounds->at_most[2].errors.share, 1.0 / 3);
  EXPECT_EQ(e.bounds->right.probes, 1);  // to 0.14 N
  for (auto& p : probes) p.bound_N = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(errors_to_range(probes, 1).bounds);
}

}  // namespace
}  // namespace phynness
