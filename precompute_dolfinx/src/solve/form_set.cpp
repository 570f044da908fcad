#include "form_set.hpp"

#include <cmath>

namespace phynness {
namespace {

/// Fraction of the shear strains that is integrated at one point. It corresponds to half of their energy
/// (docs/decisions/shell.md).
constexpr double swapped_shear = 0.7;

/// Two Gauss points through the thickness, and the replaced integral of the midsurface (forms/shell.py).
void set_passes(FormSet& set, double t) {
  const double gauss = t / (2 * std::sqrt(3.0));
  set.constants["thickness"] = t;
  for (const double zeta : {gauss, -gauss})
    set.passes.push_back({{"zeta", zeta}, {"layer", t / 2}, {"swap", 0}, {"shear", 1}});
  set.passes.push_back({{"zeta", 0}, {"layer", 0}, {"swap", t}, {"shear", swapped_shear}});
  set.jacobian_passes = {{{"zeta", t / 2}, {"shear", 1}}, {{"zeta", -t / 2}, {"shear", 1}}};
}

FormConstants constants_of(const Material& material, double modulus_Pa) {
  FormConstants constants;
  const LawRow& law = *material.law;
  for (std::size_t i = 0; i < law.parameters.size(); ++i)
    constants[law.parameters[i].constant] = material.parameters.at(i) / (law.parameters[i].is_modulus ? modulus_Pa : 1);
  for (const auto& constant : law.derived) constants[constant.name] = constant.value(material.parameters.data());
  return constants;
}

}  // namespace

FormConstants FormSet::constants_in(int region, FormConstants of_pass) const {
  if (region > 0) of_pass.insert(regions[region - 1].constants.begin(), regions[region - 1].constants.end());
  of_pass.insert(constants.begin(), constants.end());
  return of_pass;
}

FormSet form_set(const Material& material, Element element, double modulus_Pa, double thickness,
                 const std::vector<Material>& regions) {
  FormSet set;
  static_cast<CompiledForms&>(set) = compiled_forms(material.law, element);
  set.element = element;
  if (element->is_shell) {
    set.passes.clear();
    set_passes(set, thickness);
  }
  set.constants["alpha"] = set.edges.energy ? smoothed_alpha : stabilization_alpha;
  set.constants["cell_share"] = cell_share;
  set.constants.merge(constants_of(material, modulus_Pa));
  for (const auto& other : regions)
    set.regions.push_back({constants_of(other, modulus_Pa), other.shear_modulus_Pa / modulus_Pa});
  set.checks_jacobian = !material.law->linear;
  return set;
}

}  // namespace phynness
