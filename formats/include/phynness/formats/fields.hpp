// Scalar fields that the solver can store beside the displacement ([database] fields of a scene). Each is defined in
// every cell, is zero at rest, and comes to a node as the average of the cells around it.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace phynness {

/// Values are bits in the logs of a database; never renumber. In files and in this order everywhere.
enum class Field {
  von_mises_stress = 0,  ///< of the Cauchy stress
  energy_density = 1,    ///< W, stored strain energy per volume at rest
};
inline constexpr std::array<Field, 2> every_field{Field::von_mises_stress, Field::energy_density};

const char* name(Field);         ///< "von-mises-stress": in scenes, databases, models
const char* unit(Field);         ///< "Pa"
const char* column(Field);       ///< "von_mises_stress_Pa": of a table, with its unit
const char* description(Field);  ///< for people
/// Near rest the field grows with this power of the displacement, and takes the same value for the opposite one: 1 is
/// a norm, with a kink at rest, 2 a quadratic form.
int degree(Field);

std::optional<Field> field_named(std::string_view name);

}  // namespace phynness
