// Scalar fields that the solver can store beside the displacement ([database] fields of a scene). Each is
// defined in every cell, is zero at rest, and comes to a node as the average of the cells around it.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace phynness {

/// Values are bits in the logs of a database; never renumber. In files and in this order everywhere.
enum class Field { von_mises_stress, energy_density };

/// All that is known of a field but how it is computed (FormSet::fields).
struct FieldRow {
  Field field;
  const char* name;  ///< in scenes, databases, models
  const char* unit;
  const char* column;  ///< of a table, with its unit
  /// Near rest the field grows with this power of the displacement, and takes the same value for the opposite
  /// one: 1 is a norm, with a kink at rest, 2 a quadratic form.
  int degree;
  const char* description;  ///< for people
};

/// In the order of the enum.
inline constexpr FieldRow field_rows[] = {
    {Field::von_mises_stress, "von-mises-stress", "Pa", "von_mises_stress_Pa", 1,
     "von Mises stress, of the Cauchy stress"},
    {Field::energy_density, "energy-density", "J/m^3", "energy_density_J_per_m3", 2,
     "stored strain energy per volume at rest"},
};

inline constexpr auto every_field = [] {
  std::array<Field, std::size(field_rows)> fields{};
  for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = field_rows[i].field;
  return fields;
}();

constexpr const FieldRow& row(Field field) { return field_rows[static_cast<std::size_t>(field)]; }
constexpr const char* name(Field field) { return row(field).name; }
constexpr const char* unit(Field field) { return row(field).unit; }
constexpr const char* column(Field field) { return row(field).column; }
constexpr const char* description(Field field) { return row(field).description; }
constexpr int degree(Field field) { return row(field).degree; }

constexpr std::optional<Field> field_named(std::string_view name) {
  for (const auto& row : field_rows)
    if (name == row.name) return row.field;
  return std::nullopt;
}

}  // namespace phynness
