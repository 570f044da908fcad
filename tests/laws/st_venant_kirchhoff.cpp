// Claim: `st-venant-kirchhoff` is equation (7): S linear in the Green-Lagrange strain, P = F S.
#include "by_hand.hpp"

namespace phynness::test {
namespace {

TEST(StVenantKirchhoff, IsLinearInGreensStrain) {
  const auto m = hookean(law_named("st-venant-kirchhoff"), 2.7, 0.35);
  const double mu = m.shear_modulus_Pa, lambda = m.lame_lambda_Pa;
  const auto strain = [](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
    return (F.transpose() * F - Eigen::Matrix3d::Identity()) / 2;
  };
  expect_declared_as(
      m,
      [&](const Eigen::Matrix3d& F) {
        const auto E = strain(F);
        return lambda / 2 * E.trace() * E.trace() + mu * E.squaredNorm();
      },
      [&](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
        const auto E = strain(F);
        return F * (lambda * E.trace() * Eigen::Matrix3d::Identity() + 2 * mu * E);
      });
}

}  // namespace
}  // namespace phynness::test
