// Claim (patch test): if the whole boundary of an irregular mesh has the displacement u = H X, the interior has it,
// too. The energy is W(F) times the volume, its derivatives by H are P times the volume, and the pressure is that of
// the law.
//
// All elements represent this state exactly. The solver's tolerance is 1e-11 of the reactions, so that interior points
// deviate by about 1e-11 of the boundary's displacement times the ratio of the largest to the smallest stiffness (about
// 1e2): the tolerance is 1e-9. Errors of force and energy are of first and second order in this deviation.
#include "block_mesh.hpp"
#include "body_states.hpp"
#include "solve/ray_solver.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

constexpr double tolerance = 1e-9;

class PatchTest : public ::testing::TestWithParam<Case> {};

TEST_P(PatchTest, InteriorEnergyForceAndPressureMatchTheHomogeneousState) {
  const auto material = unit_material(GetParam().law, 10);
  SolverSpec spec;
  spec.element = GetParam().element;
  spec.relative_tolerance = 1e-11;
  Random random(11);
  const auto mesh = irregular(block_mesh({3, 3, 3}, {1, 1.2, 0.9}), 0.07, random);
  ASSERT_EQ(interior_nodes(mesh).size(), 8u);
  const double V = volume(mesh);
  ASSERT_NEAR(V, 1 * 1.2 * 0.9, 1e-12);

  Discretization body(mesh, form_set(material, GetParam().element, 1));
  Equilibrium equilibrium(body, {}, spec);
  equilibrium.prescribe(affine_boundary(body));
  RaySolver rays(body, equilibrium, spec);

  // Stretch, shear and some rotation.
  Eigen::Matrix3d H;
  H << 0.30, 0.15, -0.10, 0.05, -0.12, 0.20, 0.08, -0.04, -0.05;
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = H;
  const Eigen::VectorXd direction = Eigen::Map<const Eigen::VectorXd>(rows.data(), 9);
  int taken = 0;
  rays.follow(rays.rest(), direction, {0.25, 0.5, 0.75, 1.0}, false,
              [&](std::size_t, const PathStep& step, const PathPoint& point) {
                EXPECT_EQ(step.status, Status::converged);
                ++taken;
                const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + point.s * H;
                const auto expected = homogeneous_state(body, material, F);
                EXPECT_LT((as_vector(point.state) - as_vector(expected)).lpNorm<Eigen::Infinity>(), tolerance);
                EXPECT_NEAR(point.energy, V * energy_density(material, F), tolerance);
                const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P = V * first_piola(material, F);
                EXPECT_LT((point.force - Eigen::Map<const Eigen::VectorXd>(P.data(), 9)).norm(), tolerance);
                if (!GetParam().law->linear) {
                  EXPECT_NEAR(point.min_jacobian, F.determinant(), tolerance);
                }
                return true;
              });
  EXPECT_EQ(taken, 4);
}

TEST_P(PatchTest, RestStiffnessIsHookesLaw) {
  // Whatever the law, the tangent by H at rest is V times lambda I x I + 2 mu sym: linear elasticity.
  const auto material = unit_material(GetParam().law, 10);
  SolverSpec spec;
  spec.element = GetParam().element;
  Random random(11);
  const auto mesh = irregular(block_mesh({3, 3, 3}, {1, 1.2, 0.9}), 0.07, random);
  Discretization body(mesh, form_set(material, GetParam().element, 1));
  Equilibrium equilibrium(body, {}, spec);
  equilibrium.prescribe(affine_boundary(body));
  RaySolver rays(body, equilibrium, spec);

  const auto hooke = of_parameters(law_named("linear"), {material.shear_modulus_Pa, material.lame_lambda_Pa});
  Eigen::MatrixXd expected(9, 9);
  for (int c = 0; c < 9; ++c) {
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F(c / 3, c % 3) += 1;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P = volume(mesh) * first_piola(hooke, F);
    expected.col(c) = Eigen::Map<const Eigen::VectorXd>(P.data(), 9);
  }
  // One factorization and no iteration: what is left is rounding, 1e-16 times the condition number (some 1e3).
  EXPECT_LT((rays.rest().tangent - expected).norm(), 1e-12 * expected.norm());
  EXPECT_EQ(rays.rest().negative_pivots, 0);
}

INSTANTIATE_TEST_SUITE_P(Laws, PatchTest, ::testing::ValuesIn(every_case()), case_name);

}  // namespace
}  // namespace phynness::test
