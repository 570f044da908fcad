// What the claims are tested for: every law with every element, and materials whose shear modulus is the
// unit.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness::test {

struct Case {
  Law law;
  Element element;
};

inline std::string str(const Case& c) {
  auto text = std::string(name(c.law)) + "_" + name(c.element);
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}
inline std::ostream& operator<<(std::ostream& out, const Case& c) { return out << str(c); }
inline std::string case_name(const ::testing::TestParamInfo<Case>& info) { return str(info.param); }

inline std::string element_name(const ::testing::TestParamInfo<Element>& info) {
  return case_name({{Law::linear, info.param}, 0}).substr(std::string("linear_").size());
}

inline constexpr Element every_element[] = {Element::p1, Element::p2, Element::taylor_hood, Element::p1_p1};
inline constexpr Law nonlinear_laws[] = {Law::st_venant_kirchhoff, Law::neo_hookean, Law::mooney_rivlin};

inline std::vector<Case> nonlinear_cases() {
  std::vector<Case> cases;
  for (const auto law : nonlinear_laws)
    for (const auto element : every_element) cases.push_back({law, element});
  return cases;
}

inline std::vector<Case> every_case() {
  auto cases = nonlinear_cases();
  for (const auto element : every_element) cases.push_back({Law::linear, element});
  return cases;
}

/// Shear modulus 1 Pa. C01 is a fifth of the sum, so that a test sees both invariants.
inline Material unit_material(Law law, double bulk_to_shear) {
  Material material;
  material.law = law;
  material.shear_modulus_Pa = 1;
  material.bulk_modulus_Pa = bulk_to_shear;
  material.lame_lambda_Pa = bulk_to_shear - 2.0 / 3;
  material.c10_Pa = 0.4;
  material.c01_Pa = 0.1;
  return material;
}

inline Material hookean(Law law, double youngs_modulus, double poissons_ratio) {
  Material material;
  material.law = law;
  material.shear_modulus_Pa = youngs_modulus / (2 * (1 + poissons_ratio));
  material.bulk_modulus_Pa = youngs_modulus / (3 * (1 - 2 * poissons_ratio));
  material.lame_lambda_Pa = material.bulk_modulus_Pa - 2 * material.shear_modulus_Pa / 3;
  return material;
}

}  // namespace phynness::test
