// Claim: a ray that cannot continue ends with a reason. Earlier increments remain valid, and later ones are marked.
//
// St. Venant-Kirchhoff softens in compression, so that a deep probe inverts cells, and Newton's method accepts this:
// the residual of an inverted state converges like any other. Outcomes are exact; only the last test has a tolerance,
// that of the solver.
#include <gtest/gtest.h>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

std::vector<Response> ray(const ProbeBlock& block, const Vec3& displacement, int increments) {
  std::vector<double> s;
  for (int i = 1; i <= increments; ++i) s.push_back(static_cast<double>(i) / increments);
  std::vector<Response> responses;
  block.touched().follow({displacement}, s, false, [&](std::size_t i, const Response& response) {
    EXPECT_EQ(i, responses.size());
    responses.push_back(response);
    return true;
  });
  return responses;
}

class DeepPush : public ::testing::TestWithParam<Element> {};

TEST_P(DeepPush, OfStVenantKirchhoffEndsInvertedAndKeepsTheLastGoodIncrement) {
  const auto block = probe_block({law_named("st-venant-kirchhoff"), GetParam()}, 10, {6, 4, 4});
  const auto responses = ray(block, {0, 0, -0.028}, 12);
  ASSERT_EQ(responses.size(), 12u);  // every increment is reported
  const auto first_bad =
      std::find_if(responses.begin(), responses.end(), [](const Response& r) { return r.status != Status::converged; });
  ASSERT_NE(first_bad, responses.end());
  ASSERT_GT(first_bad - responses.begin(), 2);
  EXPECT_GT(first_bad->cutbacks, 0);
  for (auto r = responses.begin(); r != first_bad; ++r) EXPECT_GT(r->min_jacobian, 0);
  for (auto r = first_bad; r != responses.end(); ++r) {
    EXPECT_EQ(r->status, r == first_bad ? Status::inverted : Status::after_failure);
    EXPECT_EQ(r->force_N[0], Vec3{});
    EXPECT_EQ(r->energy_J, 0);
    EXPECT_EQ(r->displacement_m.norm(), 0);
  }

  // The last good increment is what a fresh ray to that depth finds.
  const int n_good = static_cast<int>(first_bad - responses.begin());
  const auto& last_good = responses[n_good - 1];
  const auto fresh = block.touched().solve({{0, 0, -0.028 * n_good / 12}}, n_good);
  ASSERT_EQ(fresh.status, Status::converged);
  EXPECT_NEAR(last_good.force_N[0][2], fresh.force_N[0][2], 1e-7 * std::abs(fresh.force_N[0][2]));
}

// P1-P1 and Taylor-Hood may stop with a line search that fails before the first cell turns: see the next test.
INSTANTIATE_TEST_SUITE_P(Elements, DeepPush, ::testing::Values(element_named("P1"), element_named("P2")), element_name);

class DeepPushOfMixed : public ::testing::TestWithParam<Element> {};

TEST_P(DeepPushOfMixed, OfStVenantKirchhoffFailsWithAReason) {
  const auto responses =
      ray(probe_block({law_named("st-venant-kirchhoff"), GetParam()}, 10, {6, 4, 4}), {0, 0, -0.028}, 6);
  ASSERT_EQ(responses.size(), 6u);
  EXPECT_EQ(responses.front().status, Status::converged);
  EXPECT_EQ(responses.back().status, Status::after_failure);
  int reasons = 0;
  for (const auto& r : responses) {
    if (r.status == Status::converged) {
      EXPECT_GT(r.min_jacobian, 0);
      EXPECT_EQ(reasons, 0) << "no increment may converge after a failure";
    } else if (r.status != Status::after_failure) {
      ++reasons;
    }
  }
  EXPECT_EQ(reasons, 1);
}

INSTANTIATE_TEST_SUITE_P(Elements, DeepPushOfMixed,
                         ::testing::Values(element_named("taylor-hood"), element_named("p1-p1"),
                                           element_named("es-p1-p1")),
                         element_name);

TEST(FailedSolve, ReportsTheFailureInsteadOfTheLastGoodState) {
  // solve() asks for one displacement: a state short of it is not an answer.
  const auto block = probe_block({law_named("st-venant-kirchhoff"), element_named("P1")}, 10, {6, 4, 4});
  const auto response = block.touched().solve({{0, 0, -0.028}}, 12);
  EXPECT_EQ(response.status, Status::inverted);
  EXPECT_EQ(response.force_N[0], Vec3{});
}

TEST(RayAfterAFailedOne, IsNotDisturbed) {
  const auto block = probe_block({law_named("st-venant-kirchhoff"), element_named("P1")}, 10, {6, 4, 4});
  const Vec3 shallow{0.001, 0, -0.004};
  const auto expected = block.touched().solve({shallow}, 2);
  auto solver = block.touched();
  ASSERT_NE(solver.solve({{0, 0, -0.028}}, 6).status, Status::converged);
  const auto response = solver.solve({shallow}, 2);
  EXPECT_EQ(response.status, Status::converged);
  EXPECT_EQ(response.force_N[0], expected.force_N[0]);  // the same operations, to the last bit
}

TEST(CallersWish, EndsARay) {
  int taken = 0;
  probe_block({law_named("neo-hookean"), element_named("P1")}, 10, {4, 4, 3})
      .touched()
      .follow({{0, 0, -0.01}}, {0.2, 0.4, 0.6}, false, [&](std::size_t, const Response&) { return ++taken < 2; });
  EXPECT_EQ(taken, 2);
}

}  // namespace
}  // namespace phynness::test
