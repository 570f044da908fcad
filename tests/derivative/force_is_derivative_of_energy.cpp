// Claim: the force of a probe is the derivative of the stored energy by the displacement of the tool, for node and
// patch and for several tools at once. Its integral along a ray is therefore the energy.
//
// Along a ray d = s D the force f = sum of F . D over the tools must be dE/ds. The truncation error of the seven-point
// quotient is h^6/140 times the seventh derivative; that of the integral (trapezoids corrected with df/ds = D . K D at
// the ends) is h^4/720 times the third derivative of f. On the unit ray with h = 1/16 these are 1e-9 and 1e-7 times
// derivatives of order 1 to 100. The solver's tolerance of 1e-10 is small compared with both. A missing weight of the
// tool would change 1e-1.
#include <gtest/gtest.h>

#include <numeric>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

constexpr int increments = 16;

/// Energy, force along the ray, and its slope at s = 0, h, ..., 1.
struct Ray {
  std::vector<double> E, f, slope;
};

Ray follow(ProbeSolver& solver, const std::vector<Vec3>& direction) {
  const auto dot = [&](const std::vector<Vec3>& F) {
    double sum = 0;
    for (std::size_t t = 0; t < F.size(); ++t)
      sum += std::inner_product(F[t].begin(), F[t].end(), direction[t].begin(), 0.0);
    return sum;
  };
  Eigen::VectorXd D(static_cast<Eigen::Index>(3 * direction.size()));
  for (Eigen::Index i = 0; i < D.size(); ++i) D[i] = direction[i / 3][i % 3];
  Ray ray{{0}, {0}, {D.dot(solver.rest().stiffness_N_per_m * D)}};
  std::vector<double> s;
  for (int i = 1; i <= increments; ++i) s.push_back(static_cast<double>(i) / increments);
  solver.follow(direction, s, true, [&](std::size_t, const Response& response) {
    EXPECT_EQ(response.status, Status::converged);
    ray.E.push_back(response.energy_J);
    ray.f.push_back(dot(response.force_N));
    ray.slope.push_back(D.dot(response.tangent_N_per_m * D));
    return response.status == Status::converged;
  });
  return ray;
}

void expect_conservative(ProbeSolver& solver, const std::vector<Vec3>& direction) {
  const auto [E, f, slope] = follow(solver, direction);
  ASSERT_EQ(E.size(), increments + 1u);
  const double h = 1.0 / increments;
  double work = 0;
  for (int i = 0; i < increments; ++i) {
    work += h / 2 * (f[i] + f[i + 1]) + h * h / 12 * (slope[i] - slope[i + 1]);
    EXPECT_NEAR(work, E[i + 1], 1e-5 * E.back()) << "increment " << i + 1;
  }
  for (int i = 3; i <= increments - 3; ++i) {
    const double dE_ds = (45 * (E[i + 1] - E[i - 1]) - 9 * (E[i + 2] - E[i - 2]) + (E[i + 3] - E[i - 3])) / (60 * h);
    EXPECT_NEAR(f[i], dE_ds, 1e-6 * f.back()) << "increment " << i;
  }
}

class ForceOfProbe : public ::testing::TestWithParam<std::tuple<Case, ProbeKind>> {};

TEST_P(ForceOfProbe, IsTheDerivativeOfTheEnergyAlongARay) {
  const auto& [c, kind] = GetParam();
  auto block = probe_block(c, 10, {4, 4, 3});
  block.scene.solver.relative_tolerance = 1e-10;
  block.scene.probe.kind = kind;
  if (kind == ProbeKind::patch) block.scene.probe.tool_radius_m = 0.04;
  auto solver = block.touched();
  expect_conservative(solver, {{0.004, 0.003, -0.009}});
}

std::string probe_name(const ::testing::TestParamInfo<std::tuple<Case, ProbeKind>>& info) {
  return str(std::get<0>(info.param)) + "_" + name(std::get<1>(info.param));
}
INSTANTIATE_TEST_SUITE_P(
    Elements, ForceOfProbe,
    ::testing::Combine(::testing::ValuesIn(cases({{"neo-hookean", {"P1", "P2", "taylor-hood", "p1-p1", "es-p1-p1"}},
                                                  {"st-venant-kirchhoff", {"P1"}},
                                                  {"mooney-rivlin", {"p1-p1", "es-p1-p1"}},
                                                  {"linear", {"P2"}}})),
                       ::testing::Values(ProbeKind::node, ProbeKind::patch)),
    probe_name);

class ForceOfTwoTools : public ::testing::TestWithParam<ProbeKind> {};

TEST_P(ForceOfTwoTools, SumsToTheDerivativeOfTheEnergy) {
  // The patches overlap, so the nodes between them are moved by both tools.
  auto block = probe_block({law_named("neo-hookean"), element_named("P2")}, 10, {4, 4, 3});
  block.scene.solver.relative_tolerance = 1e-10;
  block.scene.probe.kind = GetParam();
  // Wide enough for the patches to meet, too small for one to move the node that the other touches.
  if (GetParam() == ProbeKind::patch)
    block.scene.probe.tool_radius_m =
        0.95 * (block.mesh.nodes.row(block.top + 1) - block.mesh.nodes.row(block.top - 1)).norm();
  auto solver = block.solver();
  solver.touch({block.top - 1, block.top + 1});
  ASSERT_EQ(solver.rest().stiffness_N_per_m.rows(), 6);
  expect_conservative(solver, {{0.004, 0.003, -0.006}, {-0.001, 0.002, -0.003}});
}

INSTANTIATE_TEST_SUITE_P(Kinds, ForceOfTwoTools, ::testing::Values(ProbeKind::node, ProbeKind::patch),
                         [](const auto& info) { return name(info.param); });

}  // namespace
}  // namespace phynness::test
