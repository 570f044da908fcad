// Claim: errors of validation follow equation (17) of docs/theory.md. Each force and each displacement of an output
// node is divided by the largest finite element norm of the same active node and group. Nodes that the tool moves do
// not count. p95 is the nearest rank, and relative L2 is per probe. The numbers are chosen so that all results can be
// computed mentally; 1e-15 is rounding.
#include <gtest/gtest.h>

#include <phynness/validation/probed_states.hpp>
#include <phynness/validation/several_tools.hpp>
#include <phynness/validation/tools.hpp>

namespace phynness {
namespace {

constexpr double same = 1e-15;

/// Two output nodes, of which the tool holds the first. The predictor is off by `force_off` along x and by
/// `u_off` along y at the second.
ProbedState state(double force_N, double force_off, double u_m, double u_off) {
  ProbedState s;
  s.force_FE = {0, 0, force_N};
  s.force_linear = {force_off, 0, force_N};
  s.u_FE.resize(2, 3);
  s.u_FE << 0, 0, 100, u_m, 0, 0;  // the touched node moves most, and is right or wrong to no avail
  s.u_linear = s.u_FE;
  s.u_linear(0, 0) = 50;
  s.u_linear(1, 1) += u_off;
  return s;
}

NodeProbes probes() {
  NodeProbes p;
  p.node = 3;
  p.counts = {0, 1};
  p.states[0] = {state(-1, 0.4, 0.002, 0.001), state(2, 0.2, 0.004, 0.001), state(4, 0, 0.008, 0.002)};
  p.states[1] = {state(10, 5, 0.1, 0.01)};
  return p;
}

TEST(Errors, AreThoseOfEquation17) {
  const auto errors = linear_errors({probes()});
  EXPECT_EQ(errors.inside.force.n, 3);
  EXPECT_NEAR(errors.inside.force.mean, (0.1 + 0.05 + 0) / 3, same);
  EXPECT_NEAR(errors.inside.force.max, 0.1, same);
  EXPECT_NEAR(errors.inside.force.p95, 0.1, same);  // third of three: ceil(0.95 3) = 3
  EXPECT_EQ(errors.inside.displacement.n, 3);
  EXPECT_NEAR(errors.inside.displacement.mean, (0.125 + 0.125 + 0.25) / 3, same);
  EXPECT_NEAR(errors.inside.field_l2.max, 0.5, same);
  EXPECT_NEAR(errors.inside.field_l2.mean, (0.5 + 0.25 + 0.25) / 3, same);
  // A group of its own: its forces divide by its own largest.
  EXPECT_NEAR(errors.outside.force.mean, 0.5, same);
  EXPECT_NEAR(errors.outside.displacement.mean, 0.1, same);
}

TEST(Errors, OfNodesDivideByTheirOwn) {
  auto soft = probes();
  soft.node = 5;
  soft.states[1].clear();
  for (auto& s : soft.states[0]) {
    for (double& f : s.force_FE) f /= 1000;
    for (double& f : s.force_linear) f /= 1000;
  }
  const auto errors = linear_errors({probes(), soft});
  EXPECT_EQ(errors.inside.force.n, 6);
  EXPECT_NEAR(errors.inside.force.mean, (0.1 + 0.05) / 3, same);
}

TEST(Errors, P95IsTheNearestRank) {
  std::vector<double> samples;
  for (int i = 40; i >= 1; --i) samples.push_back(i);
  EXPECT_EQ(ErrorStatistics::of(samples).p95, 38);  // ceil(0.95 40)
  EXPECT_EQ(ErrorStatistics::of(samples).max, 40);
  EXPECT_EQ(ErrorStatistics::of({}).n, 0);
}

// Claim: a sample of weight 3 stands for three of weight 1.
TEST(Errors, WeightsAreNumbersOfSamples) {
  std::vector<double> samples;
  std::vector<std::pair<double, double>> weighted;
  for (int i = 40; i >= 1; --i) {
    weighted.emplace_back(i, i % 3 == 0 ? 3 : 1);
    samples.insert(samples.end(), i % 3 == 0 ? 3 : 1, i);
  }
  const auto some = weighted_statistics(weighted), all = ErrorStatistics::of(samples);
  EXPECT_EQ(some.n, 40);
  EXPECT_NEAR(some.mean, all.mean, same * all.mean);
  EXPECT_EQ(some.median, all.median);
  EXPECT_EQ(some.p95, all.p95);
  EXPECT_EQ(some.max, all.max);
}

// Claim: a mean error above 0.1 % and above that of the linear predictor is named for every kind of probe.
TEST(Errors, WorseThanLinearAreNamedForPointsAndPairs) {
  const auto constant = [](double value) { return ErrorStatistics::of({value, value}); };
  PointReport points;
  points.coupled.force = constant(0.09);
  points.linear.force = constant(0.02);
  points.coupled.displacement = constant(0.0009);
  points.linear.displacement = constant(0.0001);
  ASSERT_EQ(worse_than_linear(points, SurfacePart::probed).size(), 1);
  EXPECT_NE(worse_than_linear(points, SurfacePart::probed)[0].sentence().find(
                "for tools between nodes: mean error of the force 9.00 %"),
            std::string::npos);
  PairReport pairs;
  auto &model = pairs.unflagged.model, &linear = pairs.unflagged.linear;
  model.force = constant(0.02);
  linear.force = constant(0.03);
  model.displacement = constant(0.1);
  linear.displacement = constant(0.01);
  ASSERT_EQ(worse_than_linear(pairs).size(), 1);
  EXPECT_NE(worse_than_linear(pairs)[0].sentence().find("for two tools: mean error of the displacement 10.00 %"),
            std::string::npos);
  // A body's are its own.
  points.coupled = points.linear;
  points.body = points.linear;
  points.body->force = constant(0.05);
  ASSERT_EQ(worse_than_linear(points, SurfacePart::probed).size(), 1);
  EXPECT_NE(worse_than_linear(points, SurfacePart::probed)[0].sentence().find(
                "the reduced body is worse than the linear predictor for tools"),
            std::string::npos);
  pairs.by_body = true;
  ASSERT_EQ(worse_than_linear(pairs).size(), 1);
  EXPECT_NE(worse_than_linear(pairs)[0].sentence().find("the reduced body is worse than the linear predictor for two"),
            std::string::npos);
  EXPECT_NE(worse_than_linear(points, SurfacePart::rim)[0].sentence().find("at the rim of the probed part"),
            std::string::npos);
  EXPECT_TRUE(worse_than_linear(PointReport{}, SurfacePart::rim).empty());
  EXPECT_TRUE(worse_than_linear(PairReport{}).empty());
}

}  // namespace
}  // namespace phynness
