// Claims about every law of laws: the reference state has no energy and stress, the moduli at rest are those of the
// file, rotations of body and space have no effect, and all parameters of a scene are part of its hash.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>

#include "../messages.hpp"
#include "by_hand.hpp"

namespace phynness::test {
namespace {

std::vector<Law> every_law() {
  std::vector<Law> result;
  for (const auto& law : laws()) result.push_back(&law);
  return result;
}

/// The linear theory takes a rotation for a strain, so that these claims are not its own.
std::vector<Law> every_finite_law() {
  auto result = every_law();
  std::erase_if(result, [](Law law) { return law->linear; });
  return result;
}

class EveryLaw : public ::testing::TestWithParam<Law> {
 protected:
  const Material material = unit_material(GetParam(), 10);
};
class EveryFiniteLaw : public EveryLaw {};

TEST_P(EveryLaw, IsAtRestAtRest) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  EXPECT_NEAR(energy_density(material, I), 0, 1e-15);
  EXPECT_LT(first_piola(material, I).norm(), 1e-14);
  EXPECT_EQ(pressure(material, I), 0);
}

TEST_P(EveryLaw, HasTheModuliAtRestThatItStates) {
  // Central differences of the stress with step 1e-4: the remainder is 1e-8 times third derivatives, which
  // are of the order of the moduli.
  constexpr double step = 1e-4;
  const auto difference = [&](const Eigen::Matrix3d& direction) -> Eigen::Matrix3d {
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    return (first_piola(material, I + step * direction) - first_piola(material, I - step * direction)) / (2 * step);
  };
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero();
  shear(0, 1) = 1;
  EXPECT_NEAR(difference(shear)(0, 1), 1, 1e-5);
  EXPECT_NEAR(difference(Eigen::Matrix3d::Identity())(2, 2), 3 * 10, 1e-5 * 30);
  EXPECT_NEAR(material.shear_modulus_Pa, 1, 1e-15);
  EXPECT_NEAR(material.bulk_modulus_Pa, 10, 1e-14);
  EXPECT_NEAR(material.lame_lambda_Pa, 10 - 2.0 / 3, 1e-14);
}

TEST_P(EveryFiniteLaw, DoesNotDependOnTheFrame) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.9, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (const auto& F : some_states()) {
    const double W = energy_density(material, F);
    EXPECT_NEAR(energy_density(material, R * F), W, 1e-13) << "not objective\n" << F;
    EXPECT_NEAR(energy_density(material, F * R), W, 1e-13) << "not isotropic\n" << F;
  }
}

TEST_P(EveryFiniteLaw, StressIsSymmetricInTheDeformedBody) {
  for (const auto& F : some_states()) {
    const Eigen::Matrix3d tau = first_piola(material, F) * F.transpose();
    EXPECT_LT((tau - tau.transpose()).norm(), 1e-13) << F;
  }
}

std::string scene_of(const Material& material) {
  return "[mesh]\nshape = \"block\"\n" + scene_lines(material) +
         "[nodes]\nfixed = { nodes = [0] }\n[probe]\nmax_displacement_m = 0.01\n";
}

TEST_P(EveryLaw, IsReadFromASceneAndEveryParameterIsInItsHash) {
  const auto written = times(1e3, material);
  const auto scene = parse_scene(scene_of(written), "law.toml", ".");
  EXPECT_EQ(scene.material.law, GetParam());
  EXPECT_EQ(scene.material.parameters, written.parameters);
  for (std::size_t i = 0; i < written.parameters.size(); ++i) {
    auto other = written.parameters;
    other[i] = std::nextafter(other[i], std::numeric_limits<double>::infinity());
    const auto changed = parse_scene(scene_of(of_parameters(GetParam(), other)), "law.toml", ".");
    EXPECT_NE(physics_hash(changed), physics_hash(scene)) << GetParam()->parameters[i].key;
    EXPECT_NE(physics_summary(scene).find(std::string("\nmaterial.") + GetParam()->parameters[i].key + " = "),
              std::string::npos);
  }
}

TEST_P(EveryLaw, RefusesTooFewAndTooManyParameters) {
  const auto complete = scene_of(times(1e3, material));
  const auto expect_refused = [](const std::string& text, const char* why) {
    expect_names(message_of([&] { parse_scene(text, "law.toml", "."); }), {why});
  };
  const auto at = complete.find("[nodes]");
  expect_refused(complete.substr(0, at) + "d1_per_Pa = 1e-4\nyoungs_modulus_Pa = 3.0\n" + complete.substr(at),
                 "over-determined");
  const auto last = complete.rfind('\n', at - 2);
  expect_refused(complete.substr(0, last + 1) + complete.substr(at), "do not determine");
  EXPECT_THROW(material_of(GetParam(), {{"youngs_modulus_Pa", 1.0}}), Error);
}

std::string law_in_test_name(const ::testing::TestParamInfo<Law>& info) {
  std::string text = name(info.param);
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}
INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw, ::testing::ValuesIn(every_law()), law_in_test_name);
INSTANTIATE_TEST_SUITE_P(Laws, EveryFiniteLaw, ::testing::ValuesIn(every_finite_law()), law_in_test_name);

TEST(Laws, AreFoundByNameAndNoOtherIs) {
  EXPECT_GE(laws().size(), 4u);
  for (const auto& law : laws()) EXPECT_EQ(law_named(law.name), &law);
  EXPECT_THROW(law_named("hooke"), Error);
  for (const auto& element : elements()) EXPECT_EQ(element_named(element.name), &element);
  EXPECT_THROW(element_named("P3"), Error);
}

}  // namespace
}  // namespace phynness::test
