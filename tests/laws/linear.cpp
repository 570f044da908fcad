// Claim: `linear` is Hooke's law of small strains.
#include "by_hand.hpp"

namespace phynness::test {
namespace {

TEST(Linear, IsHookesLaw) {
  const auto m = hookean(law_named("linear"), 2.7, 0.35);
  const double mu = m.shear_modulus_Pa, lambda = m.lame_lambda_Pa;
  const auto strain = [](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
    return (F + F.transpose()) / 2 - Eigen::Matrix3d::Identity();
  };
  expect_declared_as(
      m,
      [&](const Eigen::Matrix3d& F) {
        const auto e = strain(F);
        return lambda / 2 * e.trace() * e.trace() + mu * e.squaredNorm();
      },
      [&](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
        const auto e = strain(F);
        return lambda * e.trace() * Eigen::Matrix3d::Identity() + 2 * mu * e;
      });
}

}  // namespace
}  // namespace phynness::test
