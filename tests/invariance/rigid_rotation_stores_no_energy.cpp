// Claim: the three nonlinear laws are objective for every element. A rigid motion has no energy and no force. A
// rotation after a deformation does not change the energy and rotates the forces. The linear law is not objective by
// definition.
//
// Nothing is solved. Nodal forces are sums of stress times h^2 with mu = 1 and have a rounding error of 1e-16 times the
// largest modulus (10), so that 1e-13 of mu h^2 is a sufficient tolerance. Pressures are scalars and do not rotate.
#include <gtest/gtest.h>

#include "block_mesh.hpp"
#include "body_states.hpp"
#include "dense_tangent.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

constexpr double h = 0.5, rounding = 1e-13;

const Eigen::Matrix3d rotation = Eigen::AngleAxisd(1.9, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();

Discretization irregular_cube(const Case& c, Random& random) {
  return {irregular(block_mesh({2, 2, 2}, {1, 1, 1}), 0.1, random), form_set(unit_material(c.law, 10), c.element, 1)};
}

class Objectivity : public ::testing::TestWithParam<Case> {};

TEST_P(Objectivity, RigidMotionCostsNeitherEnergyNorForce) {
  Random random(41);
  auto body = irregular_cube(GetParam(), random);
  const auto state =
      state_of(body, [](const Vector3& X) -> Vector3 { return rotation * X - X + Vector3(0.3, -0.2, 0.7); });
  EXPECT_LT(residual(body, state).lpNorm<Eigen::Infinity>(), rounding * h * h);
  EXPECT_NEAR(body.energy(state), 0, rounding);
  EXPECT_NEAR(body.min_jacobian(state), 1, rounding);
}

TEST_P(Objectivity, RotationOfADeformedStateTurnsTheForces) {
  Random random(43);
  auto body = irregular_cube(GetParam(), random);
  auto deformed = state_of(body, [&](const Vector3& X) -> Vector3 {
    const double noise = 0.02 * random();
    return Vector3(0.2 * X[1] + noise, -0.1 * X[1] * X[2], 0.15 * X[2] - noise);
  });
  for (const auto dof : body.pressure_dofs()) deformed[dof] = random();
  auto rotated = deformed;
  for (int p = 0; p < body.n_points(); ++p) {
    const Vector3 X = body.points().row(p).transpose();
    const Vector3 u = rotation * (X + value_at(body, deformed, p)) - X;
    for (int k = 0; k < 3; ++k) rotated[body.dofs(p)[k]] = u[k];
  }
  EXPECT_GT(std::abs(body.energy(deformed)), 0.01);  // negative where the pressure is rough: a saddle point
  EXPECT_NEAR(body.energy(rotated), body.energy(deformed), rounding);

  std::vector<double> before(body.n_dofs()), after(body.n_dofs());
  body.residual(deformed, before);
  body.residual(rotated, after);
  for (int p = 0; p < body.n_points(); ++p)
    EXPECT_LT((value_at(body, after, p) - rotation * value_at(body, before, p)).norm(), 10 * rounding * h * h);
  for (const auto dof : body.pressure_dofs()) EXPECT_NEAR(after[dof], before[dof], rounding);
}

INSTANTIATE_TEST_SUITE_P(Laws, Objectivity, ::testing::ValuesIn(nonlinear_cases()), case_name);

class LinearLaw : public ::testing::TestWithParam<Element> {};

TEST_P(LinearLaw, TakesARotationForAStrain) {
  // e = sym(R) - I is (cos - 1) on the plane of rotation, so at 1.9 rad the energy is of the order of mu:
  // whoever turns a body that far needs another law. Translations are free.
  Random random(41);
  auto body = irregular_cube({law_named("linear"), GetParam()}, random);
  const auto turned = state_of(body, [](const Vector3& X) -> Vector3 { return rotation * X - X; });
  EXPECT_GT(body.energy(turned), 1);
  const auto shifted = state_of(body, [](const Vector3&) { return Vector3(0.3, -0.2, 0.7); });
  EXPECT_NEAR(body.energy(shifted), 0, rounding);
  EXPECT_LT(residual(body, shifted).lpNorm<Eigen::Infinity>(), rounding * h * h);
}

INSTANTIATE_TEST_SUITE_P(Elements, LinearLaw, ::testing::ValuesIn(every_element), element_name);

}  // namespace
}  // namespace phynness::test
