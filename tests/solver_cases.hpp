// Parameters of the tests: every law with every element, and materials with a shear modulus of 1.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <phynness/formats/scene.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "closed_forms.hpp"

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
  return case_name({{law_named("linear"), info.param}, 0}).substr(std::string("linear_").size());
}

/// Of tetrahedra.
inline std::vector<Element> solids() {
  std::vector<Element> result;
  for (const auto& element : elements())
    if (!element.is_shell) result.push_back(&element);
  return result;
}
inline const std::vector<Element> every_element = solids();

inline std::vector<Case> every_case() {
  std::vector<Case> cases;
  for (const auto& law : laws())
    for (const auto element : every_element) cases.push_back({&law, element});
  return cases;
}

inline std::vector<Case> nonlinear_cases() {
  auto cases = every_case();
  std::erase_if(cases, [](const Case& c) { return c.law->linear; });
  return cases;
}

/// @param of  names of laws, each with names of elements
inline std::vector<Case> cases(const std::vector<std::pair<const char*, std::vector<const char*>>>& of) {
  std::vector<Case> cases;
  for (const auto& [law, elements] : of)
    for (const auto* element : elements) cases.push_back({law_named(law), element_named(element)});
  return cases;
}

/// @param parameters  in the order of the law's row
inline Material of_parameters(Law law, const std::vector<double>& parameters) {
  std::vector<std::pair<std::string_view, double>> given;
  for (std::size_t i = 0; i < parameters.size(); ++i) given.emplace_back(law->parameters[i].key, parameters[i]);
  return material_of(law, given);
}

/// Shear modulus 1 Pa, and the law's own example beside: a test sees every term of the energy.
inline Material unit_material(Law law, double bulk_to_shear) {
  return of_parameters(law, declared(law).example(bulk_to_shear));
}

/// All moduli times a factor.
inline Material times(double factor, const Material& material) {
  auto parameters = material.parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (material.law->parameters[i].is_modulus) parameters[i] *= factor;
  return of_parameters(material.law, parameters);
}

/// [material] of a scene.
inline std::string scene_lines(const Material& material) {
  std::ostringstream text;
  text.precision(17);
  text << "[material]\nlaw = \"" << name(material.law) << "\"\n";
  for (std::size_t i = 0; i < material.parameters.size(); ++i)
    text << material.law->parameters[i].key << " = " << material.parameters[i] << "\n";
  return text.str();
}

inline Material hookean(Law law, double youngs_modulus, double poissons_ratio) {
  return material_of(law, {{"youngs_modulus_Pa", youngs_modulus}, {"poisson_ratio", poissons_ratio}});
}

inline Material mooney_rivlin(double c10_Pa, double c01_Pa, double bulk_modulus_Pa) {
  return of_parameters(law_named("mooney-rivlin"), {c10_Pa, c01_Pa, bulk_modulus_Pa});
}

}  // namespace phynness::test
