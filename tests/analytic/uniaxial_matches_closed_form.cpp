// Claim: a bar with free sides under dead traction has the stretches of the closed form, for every law and element.
//
// The state is homogeneous, so that every element represents it exactly, and only the solver's tolerance (1e-11 of the
// load) and rounding remain. Displacements differ by about tolerance * load / stiffness < 1e-10. The published figures
// have 9 decimals, so that the tolerance is 1e-9.
#include "block_mesh.hpp"
#include "body_states.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

constexpr double tolerance = 1e-9;

SolverSpec tight(Element element) {
  SolverSpec spec;
  spec.element = element;
  spec.relative_tolerance = 1e-11;
  return spec;
}

/// Largest deviation of any point from u = (stretch_x - 1, stretch_y - 1, stretch_y - 1) X, at traction
/// `traction`.
double deviation(const Material& material, Element element, double length, double traction, double stretch_x,
                 double stretch_y) {
  Random random(7);
  const auto mesh = irregular(block_mesh({3, 2, 2}, {length, 1, 1}), 0.1, random);
  Discretization body(mesh, form_set(material, element, 1));
  Equilibrium equilibrium(body, rollers(body), tight(element));
  const auto load = dead_traction(body, mesh, {traction, 0, 0}, [&](const Vector3& X) { return X[0] == length; });
  std::vector<double> state(body.n_dofs(), 0.0);
  solve_in_steps(body, equilibrium, load, 10, state);
  const auto expected = state_of(body, [&](const Vector3& X) {
    return Vector3((stretch_x - 1) * X[0], (stretch_y - 1) * X[1], (stretch_y - 1) * X[2]);
  });
  double largest = 0;
  for (int p = 0; p < body.n_points(); ++p)
    largest = std::max(largest, (value_at(body, state, p) - value_at(body, expected, p)).norm());
  return largest;
}

/// Stretches (x, y) of uniaxial tension: P_xx = traction, P_yy = 0, by Newton's method from the unloaded
/// state. The difference quotients only steer Newton; what it converges to does not depend on them.
Eigen::Vector2d uniaxial_stretches(const Material& material, double traction) {
  Eigen::Vector2d stretch(1, 1);
  for (int step = 1; step <= 10; ++step) {
    const auto defect = [&](const Eigen::Vector2d& s) {
      const Eigen::Matrix3d P = first_piola(material, Vector3(s[0], s[1], s[1]).asDiagonal());
      return Eigen::Vector2d(P(0, 0) - traction * step / 10, P(1, 1));
    };
    for (int iteration = 0; iteration < 30; ++iteration) {
      Eigen::Matrix2d slope;
      for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d e = 1e-6 * Eigen::Vector2d::Unit(k);
        slope.col(k) = (defect(stretch + e) - defect(stretch - e)) / 2e-6;
      }
      stretch -= slope.partialPivLu().solve(defect(stretch));
    }
    EXPECT_LT(defect(stretch).norm(), 1e-12);
  }
  return stretch;
}

class UniaxialOfElement : public ::testing::TestWithParam<Element> {};

TEST_P(UniaxialOfElement, MooneyRivlinCubeWithoutC01MatchesPublishedFigures) {
  const auto material = mooney_rivlin(0.1486, 0, 2 / 0.0789);  // published as (1/D) (J-1)^2
  EXPECT_LT(deviation(material, GetParam(), 1, 0.4, 1.702083213, 1 - 0.230110999), tolerance);
}

TEST_P(UniaxialOfElement, StVenantKirchhoffBarDoublesItsLength) {
  // Stretch 2 and beta^2 = 0.1 exactly: S = E E_xx = 3/2, P = 2 S, and 1 - 2 nu E_xx = 0.1.
  EXPECT_LT(deviation(hookean(law_named("st-venant-kirchhoff"), 1, 0.3), GetParam(), 2, 3, 2, std::sqrt(0.1)),
            tolerance);
}

TEST_P(UniaxialOfElement, HookeanBarTakesPoissonsRatio) {
  EXPECT_LT(deviation(hookean(law_named("linear"), 1, 0.3), GetParam(), 2, 0.2, 1.2, 1 - 0.3 * 0.2), tolerance);
}

INSTANTIATE_TEST_SUITE_P(Elements, UniaxialOfElement, ::testing::ValuesIn(every_element), element_name);

class UniaxialOfMixedElement : public ::testing::TestWithParam<Element> {};

TEST_P(UniaxialOfMixedElement, MooneyRivlinCubeReachesTheIncompressibleLimit) {
  // c1 = c2 = 2.5, P = 13.125: u_x = 1, lateral 1/sqrt(2) - 1. With bulk modulus K the stretches deviate by a series in
  // P/K whose first term two values of K cancel: 2 u(2K) - u(K) deviates by O((P/K)^2), here 1e-8 of the strain.
  Random random(7);
  const auto mesh = irregular(block_mesh({2, 2, 2}, {1, 1, 1}), 0.1, random);
  std::vector<Vector3> corner;
  for (const double bulk : {1e5, 2e5}) {
    Discretization body(mesh, form_set(mooney_rivlin(2.5, 2.5, bulk), GetParam(), 1));
    Equilibrium equilibrium(body, rollers(body), tight(GetParam()));
    const auto load = dead_traction(body, mesh, {13.125, 0, 0}, [](const Vector3& X) { return X[0] == 1; });
    std::vector<double> state(body.n_dofs(), 0.0);
    solve_in_steps(body, equilibrium, load, 10, state);
    corner.push_back(value_at(body, state, mesh.n_nodes() - 1));
  }
  const Vector3 limit = 2 * corner[1] - corner[0];
  EXPECT_NEAR(limit[0], 1, 1e-7);
  EXPECT_NEAR(limit[1], -0.292893219, 1e-7);
  EXPECT_NEAR(limit[2], -0.292893219, 1e-7);
  // Without the extrapolation the compressibility must show, or K was not what it was said to be.
  EXPECT_NEAR(corner[0][0], 1, 1e-3);
  EXPECT_GT(std::abs(corner[0][0] - 1), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Elements, UniaxialOfMixedElement,
                         ::testing::Values(element_named("taylor-hood"), element_named("p1-p1"),
                                           element_named("es-p1-p1")),
                         element_name);

class Uniaxial : public ::testing::TestWithParam<Case> {};

TEST_P(Uniaxial, TensionAndCompressionMatchTheTwoScalarEquations) {
  // The equations are solved from the hand-written stress. St. Venant-Kirchhoff has no state below -0.55 mu.
  const auto material = unit_material(GetParam().law, 10);
  for (const double traction : {1.0, -0.3}) {
    const auto stretch = uniaxial_stretches(material, traction);
    EXPECT_GT((stretch[0] - 1) / traction, 0.2);  // a sizeable strain, or the test says little
    EXPECT_LT(deviation(material, GetParam().element, 1, traction, stretch[0], stretch[1]), tolerance) << traction;
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, Uniaxial, ::testing::ValuesIn(every_case()), case_name);

}  // namespace
}  // namespace phynness::test
