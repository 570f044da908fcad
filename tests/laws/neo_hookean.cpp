// Claim: `neo-hookean` is equation (8).
#include "by_hand.hpp"

namespace phynness::test {
namespace {

TEST(NeoHookean, IsEquationEight) {
  const auto m = hookean(law_named("neo-hookean"), 2.7, 0.45);
  const double mu = m.shear_modulus_Pa, lambda = m.lame_lambda_Pa;
  expect_declared_as(
      m,
      [&](const Eigen::Matrix3d& F) {
        const double log_J = std::log(F.determinant());
        return mu / 2 * (F.squaredNorm() - 3) - mu * log_J + lambda / 2 * log_J * log_J;
      },
      [&](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
        const Eigen::Matrix3d F_T = F.inverse().transpose();
        return mu * (F - F_T) + lambda * std::log(F.determinant()) * F_T;
      });
}

}  // namespace
}  // namespace phynness::test
