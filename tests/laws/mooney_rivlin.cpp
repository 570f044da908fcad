// Claim: `mooney-rivlin` is equation (9) with the standard sign and isochoric invariants.
#include "by_hand.hpp"

namespace phynness::test {
namespace {

TEST(MooneyRivlin, IsEquationNine) {
  constexpr double c10 = 0.4, c01 = 0.15, K = 20;
  expect_declared_as(
      mooney_rivlin(c10, c01, K),
      [](const Eigen::Matrix3d& F) {
        const Eigen::Matrix3d C = F.transpose() * F;
        const double J = F.determinant(), first = C.trace(), second = (first * first - C.squaredNorm()) / 2;
        return c10 * (std::pow(J, -2.0 / 3) * first - 3) + c01 * (std::pow(J, -4.0 / 3) * second - 3) +
               K / 2 * (J - 1) * (J - 1);
      },
      [](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
        const Eigen::Matrix3d C = F.transpose() * F, F_T = F.inverse().transpose();
        const double J = F.determinant(), first = C.trace(), second = (first * first - C.squaredNorm()) / 2;
        return 2 * c10 * std::pow(J, -2.0 / 3) * (F - first / 3 * F_T) +
               c01 * std::pow(J, -4.0 / 3) * (2 * (first * F - F * C) - 4.0 / 3 * second * F_T) + K * (J - 1) * J * F_T;
      });
}

}  // namespace
}  // namespace phynness::test
