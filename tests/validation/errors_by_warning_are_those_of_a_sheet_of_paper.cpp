// Claim: statistics of probes up to R are those of their definition: groups by warning, means of nodes, shares of drawn
// probes, forces that are off by more than a tenth of their own size; probes that the finite elements do not reach are
// counted. The numbers are chosen so that all results can be computed mentally; 1e-15 is rounding.
#include <gtest/gtest.h>

#include <phynness/phynness.hpp>
#include <phynness/validation/errors_to_range.hpp>

#include "measure/probe_records.hpp"

namespace phynness {
namespace {

constexpr double tolerance = 1e-15, R = 0.03;

ProbeResult probe(std::int32_t node, double depth_m, bool flagged, double force, double own, double u) {
  ProbeResult p;
  p.node = node;
  p.displacement_m = {0, 0, -depth_m};
  p.flagged = flagged;
  p.status = Status::converged;
  p.model = {force, own, {u, 3 * u}};
  p.linear = {2 * force, 2 * own, {2 * u, 6 * u}};
  return p;
}

ProbeResult lost(std::int32_t node, double depth_m, bool flagged, Status why, double reached_m) {
  auto p = probe(node, depth_m, flagged, 9, 9, 9);  // numbers that must not count
  p.status = why;
  p.reached_m = reached_m;
  return p;
}

std::vector<ProbeResult> probes() {
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
  const auto& all = e.all;
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
  const auto& unflagged = e.unflagged;
  EXPECT_EQ(unflagged.probes, 4);
  EXPECT_EQ(unflagged.solved, 3);
  EXPECT_NEAR(unflagged.share, 4.0 / 6, tolerance);
  EXPECT_NEAR(unflagged.model.force.mean, 0.08, tolerance);
  EXPECT_NEAR(unflagged.model.wrong, 1.0 / 3, tolerance);
  EXPECT_NEAR(unflagged.linear.force.mean, 0.16, tolerance);
  EXPECT_NEAR(e.flagged.model.force.mean, 0.08, tolerance);
  EXPECT_NEAR(e.flagged.share, 2.0 / 6, tolerance);
  EXPECT_EQ(e.beyond.probes, 1);
  EXPECT_NEAR(e.beyond.model.force.max, 0.6, tolerance);
}

TEST(ErrorsToRange, AreThoseOfNodesAndOfWhatIsNotReached) {
  const auto e = errors_to_range(probes(), R);
  ASSERT_EQ(e.nodes.size(), 2U);
  EXPECT_EQ(e.nodes[0].node, 4);
  EXPECT_NEAR(e.nodes[0].force, 0.04, tolerance);
  EXPECT_NEAR(e.nodes[0].displacement, 0.004, tolerance);
  ASSERT_EQ(e.unreached.size(), 2U);
  EXPECT_EQ(e.unreached[0].status, Status::inverted);
  const auto only_lost = errors_to_range({lost(1, 0.02, false, Status::diverged, 0)}, R);
  EXPECT_EQ(only_lost.all.solved, 0);
  EXPECT_EQ(only_lost.all.model.force.n, 0);
  EXPECT_TRUE(std::isnan(only_lost.nodes[0].force));
  EXPECT_EQ(only_lost.unflagged.share, 1);
  EXPECT_EQ(errors_to_range({}, R).all.share, 0);
}

TEST(ErrorsToRange, DivideByTheLargestResponseAndAtLeastAHundredthOfIt) {
  LargestResponse largest;
  Points u(2, 3), said(2, 3);
  u << 0, 0, 0.1, 0.004, 0, 0;
  said << 0, 0, 0.3, 0.004, 0.001, 0;
  largest.add({0, 3, 4}, u, {0, 1});
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
    for (const int i : {order, 1 - order}) largest.add({0, 0, i == 0 ? 8.0 : 1.0}, none, {}, i == 0);
    EXPECT_EQ(largest.force_N, 1);
  }
  LargestResponse crushed;
  for (const double force : {2.0, 8.0, 3.0}) crushed.add({force, 0, 0}, none, {}, true);
  EXPECT_EQ(crushed.force_N, 8);
}

TEST(ErrorsToRange, AWarningOfTheNodeIsNotOneOfTheState) {
  EXPECT_FALSE(is_flagged(PHN_OK));
  EXPECT_FALSE(is_flagged(PHN_WARNING_INCOMPLETE));
  EXPECT_TRUE(is_flagged(PHN_WARNING_OUTSIDE));
  EXPECT_TRUE(is_flagged(PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE));
  EXPECT_TRUE(is_flagged(PHN_WARNING_UNSETTLED));
}

// Claim: the shares of errors below their bound, also by thirds of the depth, are those of this table; only solved
// probes with a bound count, also in the medians of bound and force.
TEST(BoundCoverage, IsThatOfASheetOfPaper) {
  const std::vector<BoundedError> errors{{0.1, 0.1, 0.2}, {0.5, 0.2, 0.2}, {0.2, 0.3, 0.2},
                                         {0.9, 0.1, 0.4}, {1.0, 0.5, 0.9}, {0.6, 0.8, 0.8}};
  const auto c = coverage_of(errors, 1.0);
  EXPECT_EQ(c.states, 6);
  EXPECT_DOUBLE_EQ(c.all, 5.0 / 6);
  EXPECT_DOUBLE_EQ(c.thirds[0], 0.5);
  EXPECT_DOUBLE_EQ(c.thirds[1], 1);
  EXPECT_DOUBLE_EQ(c.thirds[2], 1);
  auto weighted = errors;
  weighted[2].weight = weighted[3].weight = 3;  // a node stands for three: 7 of 10 errors hold
  EXPECT_DOUBLE_EQ(coverage_of(weighted, 1.0).all, 0.7);
  EXPECT_DOUBLE_EQ(coverage_of(weighted, 1.0).thirds[0], 0.25);
  EXPECT_EQ(coverage_of({}, 1.0).states, 0);

  std::vector<ProbeResult> probes(3);
  for (auto& p : probes) {
    p.status = Status::converged;
    p.displacement_m = {0.5, 0, 0};
    p.error_N = 0.01;
    p.bound_N = 0.03;
    p.force_N = 2;
  }
  probes[1].bound_N = std::numeric_limits<double>::infinity();
  probes[2].beyond = true;
  const auto errors_of_range = errors_to_range(probes, 1);
  EXPECT_EQ(errors_of_range.bounds.value().states, 1);
  EXPECT_EQ(errors_of_range.median_bound_N, 0.03);
  EXPECT_EQ(errors_of_range.median_force_N, 2);
  for (auto& p : probes) p.bound_N = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(errors_to_range(probes, 1).bounds);
}

}  // namespace
}  // namespace phynness
