// Claim: results do not depend on the path: no displacement gives zeros, a very small one gives the stiffness at rest,
// and a large one in a single increment gives the same force as in twelve.
#include <gtest/gtest.h>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

using Vector3 = Eigen::Vector3d;

Vector3 force(const Response& response) { return Vector3::Map(response.force_N[0].data()); }

class Step : public ::testing::TestWithParam<Case> {};

TEST_P(Step, OfNothingGivesZeros) {
  auto solver = probe_block(GetParam(), 10, {4, 4, 3}).touched();
  const auto response = solver.solve({Vec3{}}, 3, true);
  EXPECT_EQ(response.status, Status::converged);
  EXPECT_EQ(response.force_N[0], Vec3{});
  EXPECT_EQ(response.energy_J, 0);
  EXPECT_EQ(response.displacement_m.norm(), 0);
  EXPECT_EQ(response.tangent_N_per_m, solver.rest().stiffness_N_per_m);
}

TEST_P(Step, OfABillionthOfTheBodyGivesTheRestStiffness) {
  // Stresses of 1e-9 mu are rounded to 1e-16 mu: seven digits are left, and the nonlinearity takes 1e-9 of
  // what it is relative to. One digit more is allowed for the sum over elements.
  const auto block = probe_block(GetParam(), 10, {4, 4, 3});
  auto solver = block.touched();
  const Vector3 d = 1e-9 * block_size_m[0] * Vector3(0.6, 0.5, -0.7);
  const auto response = solver.solve({{d[0], d[1], d[2]}}, 1);
  ASSERT_EQ(response.status, Status::converged);
  EXPECT_EQ(response.cutbacks, 0);
  const Vector3 expected = solver.rest().stiffness_N_per_m * d;
  EXPECT_LT((force(response) - expected).norm(), 1e-6 * expected.norm());
}

TEST_P(Step, OfAMillionthConvergesAtPenroseDrainIncompressibility) {
  // K/mu = 23000: rounding of the volumetric stress is that much worse than of the shear stress, and so is the
  // nonlinearity: 23000 * 1e-6 of a strain of 1e-6 per body, some ten times that in the elements. Four digits are left.
  const auto block = probe_block(GetParam(), 23000, {4, 4, 3});
  auto solver = block.touched();
  const Vector3 d(0, 0, -1e-6 * block_size_m[0]);
  const auto response = solver.solve({{d[0], d[1], d[2]}}, 1);
  ASSERT_EQ(response.status, Status::converged);
  const Vector3 expected = solver.rest().stiffness_N_per_m * d;
  EXPECT_LT((force(response) - expected).norm(), 1e-4 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(Laws, Step, ::testing::ValuesIn(every_case()), case_name);

class LongPull : public ::testing::TestWithParam<Element> {};

TEST_P(LongPull, ConvergesOnAStableBody) {
  // Mixed elements too: 20 mm outward at K/mu = 200 puts the patch under a tension of several mu.
  auto block = probe_block({law_named("neo-hookean"), GetParam()}, 200, {6, 4, 4});
  block.scene.probe.kind = ProbeKind::patch;
  block.scene.probe.tool_radius_m = 0.03;
  const auto response = block.touched().solve({{0, 0, 0.02}}, 6);
  EXPECT_EQ(response.status, Status::converged);
  EXPECT_EQ(response.negative_pivots, 0);
  EXPECT_EQ(response.cutbacks, 0);
}

INSTANTIATE_TEST_SUITE_P(Elements, LongPull, ::testing::ValuesIn(every_element), element_name);

class HugeStep : public ::testing::TestWithParam<Case> {};

TEST_P(HugeStep, GivesTheForceOfTwelveSmallOnes) {
  // 28 mm into 60 mm, almost two elements. Both solves stop at 1e-10 of the reactions; the force follows with
  // the norm of the sensitivities (some 1e1).
  auto block = probe_block(GetParam(), 10, {6, 4, 4});
  block.scene.solver.relative_tolerance = 1e-10;
  auto solver = block.touched();
  const auto once = solver.solve({{0.002, 0.001, -0.028}}, 1), twelve = solver.solve({{0.002, 0.001, -0.028}}, 12);
  ASSERT_EQ(once.status, Status::converged);
  ASSERT_EQ(twelve.status, Status::converged);
  EXPECT_LT((force(once) - force(twelve)).norm(), 1e-8 * force(twelve).norm());
  EXPECT_LT((once.displacement_m - twelve.displacement_m).norm(), 1e-8 * twelve.displacement_m.norm());
}

INSTANTIATE_TEST_SUITE_P(Laws, HugeStep,
                         ::testing::ValuesIn(cases({{"neo-hookean", {"P1", "P2", "taylor-hood", "p1-p1", "es-p1-p1"}},
                                                    {"mooney-rivlin", {"P1", "p1-p1", "es-p1-p1"}}})),
                         case_name);

}  // namespace
}  // namespace phynness::test
