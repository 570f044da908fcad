// [database] fields: the scalar fields that are stored in addition to the displacement.
#include <algorithm>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness::scene_detail {

std::vector<Field> parse_fields(const SceneTable& database) {
  std::vector<Field> fields;
  std::vector<std::string_view> known;
  for (const auto field : every_field) known.push_back(phynness::name(field));
  const auto* array = database.find("fields")->as_array();
  if (!array)
    database.reject("fields", "must be an array of names", "write fields = [\"" + std::string(known[0]) + "\"]");
  for (const auto& entry : *array) {
    const auto* word = entry.as_string();
    const auto field = word ? field_named(word->get()) : std::nullopt;
    if (!field) {
      const auto near = word ? nearest(word->get(), known) : std::string_view{};
      refuse(database.where(entry), database.label("fields") + " contains an unknown name", shown(entry),
             "write " + listed(known, " or ") + " between quotes" +
                 (near.empty() ? "" : "; did you mean \"" + std::string(near) + "\"?"));
    }
    if (std::find(fields.begin(), fields.end(), *field) != fields.end())
      refuse(database.where(entry), database.label("fields") + " contains a field twice", shown(entry),
             "name each field once");
    fields.push_back(*field);
  }
  std::sort(fields.begin(), fields.end());
  return fields;
}

}  // namespace phynness::scene_detail
