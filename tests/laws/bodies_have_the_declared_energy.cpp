// Claims: the runtime's energy of every law and its first and second derivatives are those of the law file; states in
// which a law is not defined are refused.
#include <phynness/schema/body_laws.hpp>

#include <gtest/gtest.h>

#include <random>

#include "solver_cases.hpp"

namespace phynness::test {
namespace {

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Derivatives {
  bool defined = false;
  double value = 0;
  RowMajor first;
  Eigen::Matrix<double, 9, 9> second;
};

Derivatives derivatives(runtime::BodyEnergy energy, const Material& m, const RowMajor& F) {
  Derivatives d, once;
  d.defined = energy(F.data(), m.parameters.data(), d.value, d.first.data(), d.second.data());
  EXPECT_EQ(energy(F.data(), m.parameters.data(), once.value, once.first.data(), nullptr), d.defined);
  if (d.defined) {
    // Numbers with derivatives multiply by an inverse where plain ones divide.
    EXPECT_NEAR(once.value, d.value, 1e-14 * (1 + std::abs(d.value)));
    EXPECT_LT((once.first - d.first).norm(), 1e-13 * (1 + d.first.norm()));
  }
  return d;
}

class BodyLaws : public ::testing::TestWithParam<Law> {
 protected:
  const Material material = unit_material(GetParam(), 10);
  const runtime::BodyLaw& law = *runtime::find_body_law(GetParam()->name);
};

TEST_P(BodyLaws, HaveTheDeclaredEnergyAndItsDerivatives) {
  ASSERT_EQ(law.n_parameters, static_cast<std::int32_t>(material.parameters.size()));
  std::mt19937 random(20);
  for (int i = 0; i < 20; ++i) {
    std::uniform_real_distribution<double> entry(i % 2 ? -0.4 : -0.05, i % 2 ? 0.4 : 0.05);
    const RowMajor F = RowMajor::Identity() + RowMajor::NullaryExpr([&] { return entry(random); });
    if (F.determinant() < 0.2) continue;
    const auto shape = derivatives(law.shape, material, F), volumetric = derivatives(law.volumetric, material, F);
    ASSERT_TRUE(shape.defined && volumetric.defined) << F;
    const double kappa = GetParam()->isochoric ? material.bulk_modulus_Pa : material.lame_lambda_Pa;
    const double g = pressure(material, F) / kappa, W = energy_density(material, F), J = F.determinant();
    // What a small pressure multiplies in the neo-Hookean coupling is J - 1, in the energy ln J.
    const bool by_J = GetParam() == law_named("neo-hookean");
    EXPECT_NEAR(volumetric.value, by_J ? J - 1 : g, 1e-13) << F;
    EXPECT_NEAR(shape.value + kappa / 2 * g * g, W, 1e-13 * (1 + W)) << F;
    const RowMajor P = first_piola(material, F), sum = shape.first + kappa * g / (by_J ? J : 1) * volumetric.first;
    EXPECT_LT((sum - P).norm(), 1e-12 * (1 + P.norm())) << F << "\n" << sum << "\n" << P;
    // Central differences with step 1e-5: the remainder is 1e-10 times third derivatives of the first derivative, up to
    // thousands of moduli in the small volumes.
    for (const auto energy : {law.shape, law.volumetric}) {
      const auto here = derivatives(energy, material, F);
      for (int k = 0; k < 9; ++k) {
        RowMajor more = F, less = F;
        more.data()[k] += 1e-5;
        less.data()[k] -= 1e-5;
        const RowMajor slope =
            (derivatives(energy, material, more).first - derivatives(energy, material, less).first) / 2e-5;
        for (int l = 0; l < 9; ++l) EXPECT_NEAR(here.second(k, l), slope.data()[l], 1e-7 * (1 + slope.norm())) << F;
      }
    }
  }
}

TEST_P(BodyLaws, AreDefinedForPositiveVolumesOnly) {
  RowMajor F = RowMajor::Identity();
  F(2, 2) = -1;
  EXPECT_EQ(derivatives(law.shape, material, F).defined, GetParam()->linear);
  F(2, 2) = 0;
  EXPECT_EQ(derivatives(law.volumetric, material, F).defined, GetParam()->linear);
  F(2, 2) = std::nan("");
  EXPECT_FALSE(derivatives(law.shape, material, F).defined);
}

INSTANTIATE_TEST_SUITE_P(Laws, BodyLaws, ::testing::ValuesIn([] {
                           std::vector<Law> every;
                           for (const auto& law : laws()) every.push_back(&law);
                           return every;
                         }()));

TEST(BodyLaws, RefuseTautChainsAndUnknownNames) {
  const auto gent = of_parameters(law_named("gent"), {1, 20, 10});
  // I1bar - 3 is 19.5 and 20.5.
  for (const double stretch : {4.7, 4.8}) {
    const RowMajor F = Eigen::Vector3d(stretch, 1 / std::sqrt(stretch), 1 / std::sqrt(stretch)).asDiagonal();
    EXPECT_EQ(derivatives(runtime::find_body_law("gent")->shape, gent, F).defined,
              declared(gent.law).inside(F, gent.parameters.data()) > 0);
  }
  EXPECT_EQ(runtime::find_body_law("hooke"), nullptr);
}

}  // namespace
}  // namespace phynness::test
