// Scalar fields that the solver can store in addition to the displacement ([database] fields of a scene). Each is
// defined in every cell and is zero at rest. Its value at a node is the average of the cells around the node.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace phynness {

/// The values are bits in the logs of a database: never renumber. Fields have this order in all files.
enum class Field { von_mises_stress, energy_density };

/// Properties of a field. FormSet::fields computes it.
struct FieldRow {
  Field field;
  const char* name;  ///< in scenes, databases and models
  const char* unit;
  const char* column;  ///< heading in tables, with the unit
  /// Near rest the field grows with this power of the displacement and has the same value for the opposite
  /// displacement. 1: a norm, with a kink at rest; 2: a quadratic form.
  int degree;
  const char* description;  ///< in words
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
