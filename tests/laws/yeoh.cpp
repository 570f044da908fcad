// Claims: `yeoh` is Yeoh's law with the isochoric invariant; without its higher terms it is Mooney-Rivlin
// without C01; a shell of it is refused, as it is not condensed.
#include "../messages.hpp"
#include "by_hand.hpp"

namespace phynness::test {
namespace {

TEST(Yeoh, IsAPolynomialInTheFirstInvariant) {
  constexpr double c10 = 0.5, c20 = -0.07, c30 = 0.03, K = 20;
  const auto x = [](const Eigen::Matrix3d& F) { return std::pow(F.determinant(), -2.0 / 3) * F.squaredNorm() - 3; };
  expect_declared_as(
      of_parameters(law_named("yeoh"), {c10, c20, c30, K}),
      [&](const Eigen::Matrix3d& F) {
        const double J = F.determinant();
        return c10 * x(F) + c20 * std::pow(x(F), 2) + c30 * std::pow(x(F), 3) + K / 2 * (J - 1) * (J - 1);
      },
      [&](const Eigen::Matrix3d& F) -> Eigen::Matrix3d {
        const Eigen::Matrix3d F_T = F.inverse().transpose();
        const double J = F.determinant(), slope = c10 + 2 * c20 * x(F) + 3 * c30 * x(F) * x(F);
        return slope * 2 * std::pow(J, -2.0 / 3) * (F - F.squaredNorm() / 3 * F_T) + K * (J - 1) * J * F_T;
      });
}

TEST(Yeoh, WithoutHigherTermsIsMooneyRivlinWithoutItsSecond) {
  const auto yeoh = of_parameters(law_named("yeoh"), {0.5, 0, 0, 20});
  for (const auto& F : some_states())
    EXPECT_NEAR(energy_density(yeoh, F), energy_density(mooney_rivlin(0.5, 0, 20), F), 1e-14);
}

TEST(Yeoh, HasNoShell) {
  const auto scene = "[mesh]\nshape = \"drain\"\n" + scene_lines(unit_material(law_named("yeoh"), 100)) +
                     "[nodes]\nfixed = { nodes = [0] }\n[probe]\nmax_displacement_m = 0.001\n";
  expect_names(message_of([&] { parse_scene(scene, "yeoh.toml", "."); }),
               {"yeoh.toml:", "[material] law", "shell", "st-venant-kirchhoff"});
}

}  // namespace
}  // namespace phynness::test
