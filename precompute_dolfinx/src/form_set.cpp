#include "form_set.hpp"

#include <linear.h>
#include <mooney_rivlin.h>
#include <neo_hookean.h>
#include <shell_linear.h>
#include <shell_mooney_rivlin.h>
#include <shell_neo_hookean.h>
#include <shell_st_venant_kirchhoff.h>
#include <st_venant_kirchhoff.h>

#include <array>
#include <cmath>

namespace phynness {
namespace {

// One row per element, in the order of enum Element; ffcx numbers expressions in the order of mechanics.py.
#define PHYNNESS_FORMS(law, name, number, element)                                                           \
  FormSet {                                                                                                  \
    form_##law##_##name##_energy, form_##law##_##name##_residual, form_##law##_##name##_tangent,             \
        {form_##law##_##name##_von_mises, form_##law##_##name##_stored}, expression_##law##_##number,        \
        nullptr, nullptr, nullptr, element, {}                                                               \
  }
#define PHYNNESS_LAW(law)                                                                              \
  std::array<FormSet, 4> {                                                                             \
    PHYNNESS_FORMS(law, p1, 0, Element::p1), PHYNNESS_FORMS(law, p2, 1, Element::p2),                  \
        PHYNNESS_FORMS(law, th, 2, Element::taylor_hood), PHYNNESS_FORMS(law, p1p1, 3, Element::p1_p1) \
  }

std::array<FormSet, 4> forms_of(Law law) {
  switch (law) {
    case Law::linear:
      return PHYNNESS_LAW(linear);
    case Law::st_venant_kirchhoff:
      return PHYNNESS_LAW(st_venant_kirchhoff);
    case Law::neo_hookean:
      return PHYNNESS_LAW(neo_hookean);
    case Law::mooney_rivlin:
      break;
  }
  return PHYNNESS_LAW(mooney_rivlin);
}

#define PHYNNESS_SHELL(law)                                                                               \
  FormSet {                                                                                               \
    form_shell_##law##_energy, form_shell_##law##_residual, form_shell_##law##_tangent, {},               \
        expression_shell_##law##_orientation, form_shell_##law##_gauge_energy,                            \
        form_shell_##law##_gauge_residual, form_shell_##law##_gauge_tangent, Element::shell, {}           \
  }

FormSet shell_forms_of(Law law) {
  switch (law) {
    case Law::linear:
      return PHYNNESS_SHELL(linear);
    case Law::st_venant_kirchhoff:
      return PHYNNESS_SHELL(st_venant_kirchhoff);
    case Law::neo_hookean:
      return PHYNNESS_SHELL(neo_hookean);
    case Law::mooney_rivlin:
      break;
  }
  return PHYNNESS_SHELL(mooney_rivlin);
}

/// Share of the shear strains that is integrated at one point: half of their energy
/// (docs/decisions/shell.md).
constexpr double swapped_shear = 0.7;

/// Two Gauss points through the thickness, and the middle surface's change of integral (forms/shell.py).
void set_passes(FormSet& set, double t) {
  const double gauss = t / (2 * std::sqrt(3.0));
  set.constants["thickness"] = t;
  for (const double zeta : {gauss, -gauss})
    set.passes.push_back({{"zeta", zeta}, {"layer", t / 2}, {"swap", 0}, {"shear", 1}});
  set.passes.push_back({{"zeta", 0}, {"layer", 0}, {"swap", t}, {"shear", swapped_shear}});
  set.jacobian_passes = {{{"zeta", t / 2}, {"shear", 1}}, {{"zeta", -t / 2}, {"shear", 1}}};
}

#undef PHYNNESS_SHELL
#undef PHYNNESS_LAW
#undef PHYNNESS_FORMS

}  // namespace

FormSet form_set(const Material& material, Element element, double modulus_Pa, double thickness) {
  const bool shell = element == Element::shell;
  FormSet set =
      shell ? shell_forms_of(material.law) : forms_of(material.law)[static_cast<std::size_t>(element)];
  if (shell) {
    set.passes.clear();
    set_passes(set, thickness);
  }
  set.constants["alpha"] = stabilization_alpha;
  if (material.law == Law::mooney_rivlin) {
    set.constants["c10"] = material.c10_Pa / modulus_Pa;
    set.constants["c01"] = material.c01_Pa / modulus_Pa;
    set.constants["bulk"] = material.bulk_modulus_Pa / modulus_Pa;
  } else {
    set.constants["mu"] = material.shear_modulus_Pa / modulus_Pa;
    set.constants["lmbda"] = material.lame_lambda_Pa / modulus_Pa;
    set.constants["couples_J"] = material.lame_lambda_Pa >= 2 * material.shear_modulus_Pa ? 1 : 0;
  }
  set.checks_jacobian = material.law != Law::linear;
  return set;
}

}  // namespace phynness
