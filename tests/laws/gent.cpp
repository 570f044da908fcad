// Claims: `gent` is Gent's law with the isochoric invariant; its energy ends where I1bar - 3 reaches J_m;
// with a distant limit it is Mooney-Rivlin without C01.
#include "by_hand.hpp"

namespace phynness::test {
namespace {

constexpr double mu = 1.2, K = 20;

double invariant(const Eigen::Matrix3d& F) { return std::pow(F.determinant(), -2.0 / 3) * F.squaredNorm() - 3; }

TEST(Gent, IsALogarithmOfWhatIsLeftOfTheChains) {
  constexpr double j_m = 2.5;
  expect_declared_as(
      of_parameters(law_named("gent"), {mu, j_m, K}),
      [](const Eigen::Matrix3d& F) {
        const double J = F.determinant();
        return -mu * j_m / 2 * std::log1p(-invariant(F) / j_m) + K / 2 * (J - 1) * (J - 1);
      },
      [](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
        const Eigen::Matrix3d F_T = F.inverse().transpose();
        const double J = F.determinant(), slope = mu / 2 / (1 - invariant(F) / j_m);
        return slope * 2 * std::pow(J, -2.0 / 3) * (F - F.squaredNorm() / 3 * F_T) + K * (J - 1) * J * F_T;
      });
}

TEST(Gent, EndsWhereTheChainsLock) {
  // Stretched by s at constant volume: s^2 + 2 / s - 3 = J_m at the limit.
  constexpr double limit = 3, j_m = limit * limit + 2 / limit - 3;
  const auto material = of_parameters(law_named("gent"), {mu, j_m, K});
  const auto energy = [&](double s) {
    return energy_density(material, Eigen::Vector3d(s, 1 / std::sqrt(s), 1 / std::sqrt(s)).asDiagonal());
  };
  double last = 0;
  for (const double s : {1.5, 2.0, 2.9, 2.999, 2.999999}) {
    EXPECT_GT(energy(s), last) << s;
    last = energy(s);
  }
  for (const double s : {3.001, 4.0, 100.0}) EXPECT_TRUE(std::isnan(energy(s))) << s;
}

TEST(Gent, WithADistantLimitIsMooneyRivlinWithoutItsSecondTerm) {
  // The first term left out is mu x^2 / (4 J_m), with x = I1bar - 3 below 1 in these states.
  constexpr double j_m = 1e6;
  const auto gent = of_parameters(law_named("gent"), {mu, j_m, K});
  for (const auto& F : some_states())
    EXPECT_NEAR(energy_density(gent, F), energy_density(mooney_rivlin(mu / 2, 0, K), F), mu / j_m);
}

}  // namespace
}  // namespace phynness::test
