// The tables of keys in formats/scene.md.
#include <algorithm>
#include <cctype>

#include "scene_keys.hpp"

namespace phynness {
namespace {

std::string block(const std::string& name, const std::string& table) {
  return "<!-- keys: " + name + " -->\n\n" + table + "\n<!-- keys: end -->\n";
}

/// Words of a scene stand in quotes, numbers and booleans do not.
std::string shown_default(const std::string& text) {
  const bool word = !text.empty() && std::isalpha(static_cast<unsigned char>(text[0]));
  return word && text != "true" && text != "false" ? "`\"" + text + "\"`" : text;
}

std::string section_table(std::string_view section) {
  std::string table = "| key | type | default | range, meaning |\n|---|---|---|---|\n";
  for (const auto& key : scene_detail::key_rows()) {
    if (key.section != section) continue;
    const char* joint = key.allowed.empty() || key.meaning.empty() ? "" : "; ";
    table.append("| `").append(key.name).append("` | ").append(key.type).append(" | ");
    table.append(shown_default(key.standard)).append(" | ");
    table.append(key.allowed).append(joint).append(key.meaning).append(" |\n");
  }
  return table;
}

/// Each shape with the number of nodes and the dimensions that it has by default.
std::string shape_table() {
  std::string table = "| `shape` | `target_nodes` | dimensions |\n|---|---|---|\n";
  for (const auto& shape : shapes()) {
    Scene scene;
    scene.mesh.shape = shape.shape;
    scene.mesh = with_standard_sizes(scene.mesh);
    const auto keys = scene_detail::shape_keys(shape.shape);
    std::string dimensions;
    for (const auto& key : scene_detail::key_rows())
      if (key.section == "mesh" && std::find(keys.begin(), keys.end(), key.name) != keys.end())
        dimensions.append(dimensions.empty() ? "`" : ", `").append(key.name).append("` = ").append(key.text(scene));
    table.append("| `\"").append(shape.name).append("\"` | ").append(std::to_string(shape.target_nodes)).append(" | ");
    table.append(dimensions).append(" |\n");
  }
  const ShapeRow &tube = row(Shape::tube), &drain = row(Shape::drain);
  return table + "\nBeside another dimension that is given, `inner_radius_m` is " + scene_detail::shortest(tube.wall) +
         " `radius_m`, `slit_length_m` is " + scene_detail::shortest(drain.slit) +
         " `length_m`, and `slit_width_m` is half of `radius_m`, but at most " +
         scene_detail::shortest(drain.slit_width_m) + ".\n";
}

}  // namespace

std::string scene_key_tables() {
  std::string blocks;
  for (const auto section : scene_detail::keys_of(""))
    if (section != "title" && section != "material")  // the keys of [material] are those of the laws
      blocks += block(std::string(section), section_table(section)) + '\n';
  return blocks + block("shapes", shape_table());
}

}  // namespace phynness
