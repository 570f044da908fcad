// Claim: the solver's check of a state returns det F if the energy of the law is defined, and a value of at most zero
// otherwise: for inverted cells (J <= 0) and for states that the law excludes (`inside` of its file). In a homogeneous
// state of straight cells det F is constant, so that only rounding remains.
#include "block_mesh.hpp"
#include "body_states.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

class Domain : public ::testing::TestWithParam<Case> {};

TEST_P(Domain, OfALawIsThatOfTheSolversCheck) {
  const auto material = unit_material(GetParam().law, 10);
  Random random(5);
  const auto mesh = irregular(block_mesh({2, 2, 2}, {1, 1, 1}), 0.05, random);
  Discretization body(mesh, form_set(material, GetParam().element, 1));
  const auto inside = declared(GetParam().law).inside;
  int ended = 0;
  for (const double stretch : {0.5, 1.0, 2.0, 4.0, 20.0}) {
    const Eigen::Matrix3d F = Vector3(stretch, 1.1 / std::sqrt(stretch), 1 / std::sqrt(stretch)).asDiagonal();
    const auto state = state_of(body, [&](const Vector3& X) -> Vector3 { return F * X - X; });
    const bool has_energy = !inside || inside(F, material.parameters.data()) > 0;
    EXPECT_EQ(std::isfinite(energy_density(material, F)), has_energy) << stretch;
    if (has_energy)
      EXPECT_NEAR(body.min_jacobian(state), F.determinant(), 1e-11) << stretch;
    else
      EXPECT_LE(body.min_jacobian(state), 0) << stretch;
    ended += !has_energy;
  }
  // A law that says where it ends is to be met there, and not at rest only.
  EXPECT_EQ(ended > 0, inside != nullptr);
  EXPECT_LT(ended, 4);
  const auto inverted = state_of(body, [](const Vector3& X) { return Vector3(-1.5 * X[0], 0, 0); });
  EXPECT_LE(body.min_jacobian(inverted), 0);
}

INSTANTIATE_TEST_SUITE_P(Cases, Domain, ::testing::ValuesIn(nonlinear_cases()), case_name);

}  // namespace
}  // namespace phynness::test
