#include "form_set.hpp"

#include <linear.h>
#include <mooney_rivlin.h>
#include <neo_hookean.h>
#include <st_venant_kirchhoff.h>

#include <array>

namespace phynness {
namespace {

// One row per element, in the order of enum Element; ffcx numbers expressions in the order of mechanics.py.
#define PHYNNESS_FORMS(law, name, number, element)                                                           \
  FormSet {                                                                                                  \
    form_##law##_##name##_energy, form_##law##_##name##_residual, form_##law##_##name##_tangent,             \
        form_##law##_##name##_von_mises, form_##law##_##name##_stored, expression_##law##_##number, element, \
    {}                                                                                                       \
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

#undef PHYNNESS_LAW
#undef PHYNNESS_FORMS

}  // namespace

FormSet form_set(const Material& material, Element element, double modulus_Pa) {
  FormSet set = forms_of(material.law)[static_cast<std::size_t>(element)];
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
