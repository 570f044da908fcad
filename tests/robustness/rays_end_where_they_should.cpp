// Claims: a ray ends where its body loses energy at once, where a cell is crushed, or where the force exceeds its
// limit, at the depth where small steps find this, for any number of increments. Increments beyond are not solved. A
// ray without such an end is the same, bit for bit, with and without the search.
#include <gtest/gtest.h>

#include <cmath>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

constexpr double depth_m = 0.045;  // three quarters of the height

ProbeBlock deep_block() { return probe_block({law_named("neo-hookean"), element_named("p1-p1")}, 200, {6, 4, 4}); }

/// Towards an edge, where the block folds at about 37 mm.
Vec3 folding() { return {std::sqrt(0.5), 0, -std::sqrt(0.5)}; }

std::vector<double> steps(int n) {
  std::vector<double> s;
  for (int i = 1; i <= n; ++i) s.push_back(depth_m * i / n);
  return s;
}

struct Followed {
  std::vector<Response> responses;
  RayEnd end;
};

Followed follow(ProbeSolver& solver, const Vec3& direction, const std::vector<double>& s, const RayLimits& limits) {
  Followed ray;
  ray.end = solver.follow(
      {direction}, s, false,
      [&](std::size_t i, const Response& response) {
        EXPECT_EQ(i, ray.responses.size());
        ray.responses.push_back(response);
        return true;
      },
      limits);
  EXPECT_EQ(ray.responses.size(), s.size());
  return ray;
}

RayLimits folds_only() {
  RayLimits limits;
  limits.find_folds = true;
  limits.resolution = depth_m / 64;
  return limits;
}

void expect_same(const Response& a, const Response& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.force_N, b.force_N);
  EXPECT_EQ(a.energy_J, b.energy_J);
  EXPECT_EQ(a.min_jacobian, b.min_jacobian);
  EXPECT_EQ(a.negative_pivots, b.negative_pivots);
  EXPECT_EQ(a.displacement_m, b.displacement_m);
}

/// Checks that the increments up to the end are converged and that the others cost nothing.
void expect_cut(const Followed& ray, std::size_t n_kept) {
  for (std::size_t i = 0; i < ray.responses.size(); ++i) {
    const Response& r = ray.responses[i];
    EXPECT_EQ(r.status, i < n_kept ? Status::converged : Status::after_end) << i;
    if (i > n_kept) {
      EXPECT_EQ(r.iterations, 0) << i;
    }
  }
}

TEST(RaysEnd, AtTheFoldThatSmallStepsFind) {
  const auto block = deep_block();
  auto solver = block.touched();
  // Steps of a hundredth of an edge of the mesh: forces jump within one of them, and the work up to and beyond the jump
  // is known by the trapezoidal rule.
  std::vector<double> s;
  for (int i = 0; i <= 16; ++i) s.push_back(0.0365 + 1e-4 * i);
  const auto fine = follow(solver, folding(), s, {});
  std::size_t jump = 1;
  double lost = 0;
  for (std::size_t i = 1; i < s.size(); ++i) {
    ASSERT_EQ(fine.responses[i].status, Status::converged);
    const auto force = [&](std::size_t k) {
      const auto& f = fine.responses[k].force_N[0];
      return f[0] * folding()[0] + f[1] * folding()[1] + f[2] * folding()[2];
    };
    const double missing =
        (force(i) + force(i - 1)) / 2 * 1e-4 - (fine.responses[i].energy_J - fine.responses[i - 1].energy_J);
    if (missing > lost) {
      lost = missing;
      jump = i;
    }
  }
  ASSERT_GT(lost, 0.02 * fine.responses[jump].energy_J);

  for (const int n : {6, 12}) {
    const auto ray = follow(solver, folding(), steps(n), folds_only());
    EXPECT_EQ(ray.end.reason, EndReason::fold);
    EXPECT_LE(ray.end.depth_m, s[jump]);
    EXPECT_GE(ray.end.fold_depth_m, s[jump - 1]);
    EXPECT_LE(ray.end.fold_depth_m - ray.end.depth_m, depth_m / 64 * (1 + 1e-9));
    // The work is known up to the jump of the force times half the length to which the fold is located, a sixth.
    EXPECT_NEAR(ray.end.energy_lost_J, lost, 0.25 * lost);
    expect_cut(ray, static_cast<std::size_t>(ray.end.depth_m / depth_m * n));
  }
}

TEST(RaysEnd, OrGoOnAsBeforeIfTheSceneSaysSo) {
  const auto block = deep_block();
  auto solver = block.touched();
  auto limits = folds_only();
  limits.stop_at_fold = false;
  const auto plain = follow(solver, folding(), steps(6), {});
  const auto ray = follow(solver, folding(), steps(6), limits);
  EXPECT_EQ(plain.end.reason, EndReason::full_depth);
  EXPECT_EQ(plain.end.fold_depth_m, 0);
  EXPECT_EQ(ray.end.reason, EndReason::full_depth);
  EXPECT_EQ(ray.end.depth_m, steps(6).back());
  EXPECT_GT(ray.end.fold_depth_m, 0.036);
  EXPECT_GT(ray.end.energy_lost_J, 0);
  for (std::size_t i = 0; i < 6; ++i) expect_same(ray.responses[i], plain.responses[i]);
}

TEST(RaysEnd, NowhereIfTheBodyNeitherFoldsNorIsCrushed) {
  const auto block = deep_block();
  auto solver = block.touched();
  auto limits = folds_only();
  limits.min_jacobian = 0.03;
  limits.max_force_N = 100;
  for (const Vec3& direction : {Vec3{0, 0, -1}, Vec3{1, 0, 0}, Vec3{0, std::sqrt(0.5), std::sqrt(0.5)}}) {
    const auto plain = follow(solver, direction, steps(4), {});
    const auto ray = follow(solver, direction, steps(4), limits);
    EXPECT_EQ(ray.end.reason, EndReason::full_depth);
    EXPECT_EQ(ray.end.depth_m, steps(4).back());
    EXPECT_EQ(ray.end.fold_depth_m, 0);
    EXPECT_EQ(ray.end.energy_lost_J, 0);
    for (std::size_t i = 0; i < 4; ++i) {
      expect_same(ray.responses[i], plain.responses[i]);
      EXPECT_EQ(ray.responses[i].iterations, plain.responses[i].iterations);
    }
  }
}

TEST(RaysEnd, BeforeACellIsCrushed) {
  const auto block = deep_block();
  auto solver = block.touched();
  RayLimits limits;
  limits.min_jacobian = 0.2;
  const auto plain = follow(solver, folding(), steps(9), {});
  std::size_t n_kept = 0;
  while (plain.responses[n_kept].min_jacobian >= limits.min_jacobian) ++n_kept;
  ASSERT_GT(n_kept, 1U);
  const auto ray = follow(solver, folding(), steps(9), limits);
  EXPECT_EQ(ray.end.reason, EndReason::crushed);
  EXPECT_GE(ray.end.depth_m, depth_m * static_cast<double>(n_kept) / 9);
  EXPECT_LE(ray.end.depth_m, depth_m * static_cast<double>(n_kept + 1) / 9);
  expect_cut(ray, n_kept);
  for (std::size_t i = 0; i < n_kept; ++i) expect_same(ray.responses[i], plain.responses[i]);
}

TEST(RaysEnd, AfterTheFirstIncrementBeyondTheForceLimit) {
  const auto block = deep_block();
  auto solver = block.touched();
  const Vec3 direction{0, 0, -1};
  const auto plain = follow(solver, direction, steps(6), {});
  const auto size = [](const Response& r) { return std::hypot(r.force_N[0][0], r.force_N[0][1], r.force_N[0][2]); };
  RayLimits limits;
  limits.max_force_N = (size(plain.responses[1]) + size(plain.responses[2])) / 2;
  const auto ray = follow(solver, direction, steps(6), limits);
  EXPECT_EQ(ray.end.reason, EndReason::force_limit);
  EXPECT_EQ(ray.end.depth_m, steps(6)[2]);
  expect_cut(ray, 3);
  EXPECT_EQ(ray.responses[3].iterations, 0);
  for (std::size_t i = 0; i < 3; ++i) expect_same(ray.responses[i], plain.responses[i]);
  // A limit that is reached within the last increment cuts nothing.
  limits.max_force_N = (size(plain.responses[4]) + size(plain.responses[5])) / 2;
  EXPECT_EQ(follow(solver, direction, steps(6), limits).end.reason, EndReason::full_depth);
}

TEST(RaysEnd, WithTheReasonSolverWhereNoEquilibriumIsFound) {
  const auto block = probe_block({law_named("st-venant-kirchhoff"), element_named("P1")}, 10, {6, 4, 4});
  auto solver = block.touched();
  std::vector<double> s;
  for (int i = 1; i <= 12; ++i) s.push_back(0.028 * i / 12);
  const auto ray = follow(solver, {0, 0, -1}, s, {});
  EXPECT_EQ(ray.end.reason, EndReason::solver);
  std::size_t n_good = 0;
  while (ray.responses[n_good].status == Status::converged) ++n_good;
  EXPECT_GE(ray.end.depth_m, s[n_good - 1]);
  EXPECT_LT(ray.end.depth_m, s[n_good]);
}

}  // namespace
}  // namespace phynness::test
