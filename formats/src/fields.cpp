#include <phynness/formats/fields.hpp>

namespace phynness {

const char* name(Field field) {
  return field == Field::von_mises_stress ? "von-mises-stress" : "energy-density";
}

const char* unit(Field field) { return field == Field::von_mises_stress ? "Pa" : "J/m^3"; }

const char* column(Field field) {
  return field == Field::von_mises_stress ? "von_mises_stress_Pa" : "energy_density_J_per_m3";
}

const char* description(Field field) {
  return field == Field::von_mises_stress ? "von Mises stress, of the Cauchy stress"
                                          : "stored strain energy per volume at rest";
}

int degree(Field field) { return field == Field::von_mises_stress ? 1 : 2; }

std::optional<Field> field_named(std::string_view word) {
  for (const auto field : every_field)
    if (word == name(field)) return field;
  return std::nullopt;
}

}  // namespace phynness
