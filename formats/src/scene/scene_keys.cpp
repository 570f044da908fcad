#include "scene_keys.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/formats/scene.hpp>

#include "selectors.hpp"

namespace phynness {
namespace scene_detail {
namespace {

struct Table {
  std::string name;
  std::vector<std::string_view> keys;
};

/// The keys of all laws, each once. The elastic moduli come first, so that messages about them do not change when a law
/// is added.
void add_numbers_of_laws(std::vector<std::string_view>& keys) {
  for (const bool linear : {true, false})
    for (const auto& law : laws())
      for (const auto& set : law.accepted)
        for (const auto& quantity : set.given)
          if (law.linear == linear && std::find(keys.begin(), keys.end(), quantity.key) == keys.end())
            keys.push_back(quantity.key);
}

void add_selectors(std::vector<Table>& tables) {
  Table names{"selector", {}};
  for (const auto& row : selector_rows())
    if (row.form != SelectorForm::word) names.keys.push_back(row.name);
  names.keys.insert(names.keys.end(), std::begin(keys_beside_values), std::end(keys_beside_values));
  names.keys.push_back("surface_only");
  tables.push_back(std::move(names));
  for (const auto& row : selector_rows())
    if (row.form == SelectorForm::table) tables.push_back({"selector." + std::string(row.name), row.keys});
}

const std::vector<Table>& tables() {
  static const std::vector<Table> all = [] {
    std::vector<Table> list{{"", {}}};
    for (const auto& key : key_rows()) {
      if (key.section != list.back().name) {
        list.front().keys.push_back(key.section);
        list.push_back({std::string(key.section), {}});
      }
      list.back().keys.push_back(key.name);
    }
    for (auto& table : list)
      if (table.name == "material" || table.name == "region") add_numbers_of_laws(table.keys);
    add_selectors(list);
    return list;
  }();
  return all;
}

// The longest comes first, so that "_per_Pa" is not taken for "_Pa".
constexpr std::array<std::string_view, 5> units = {"_per_Pa", "_to_m", "_fraction", "_Pa", "_m"};

std::string_view unit_of(std::string_view key) {
  for (auto unit : units)
    if (key.size() > unit.size() && key.ends_with(unit)) return unit;
  return {};
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string bracketed(std::string_view table) {
  std::string text = "the top level";
  if (!table.empty()) text.assign("[").append(table).append("]");
  return text;
}

}  // namespace

const std::vector<std::string_view>& keys_of(std::string_view table) {
  const auto found = std::find_if(tables().begin(), tables().end(), [&](const Table& t) { return t.name == table; });
  static const std::vector<std::string_view> none;
  return found == tables().end() ? none : found->keys;
}

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  std::string_view best;
  std::size_t best_distance = 0;
  for (auto candidate : candidates) {
    const std::size_t distance = edit_distance(lower(word), lower(candidate));
    if (best.empty() || distance < best_distance) best = candidate, best_distance = distance;
  }
  const std::size_t tolerated = std::max<std::size_t>(2, word.size() / 3);
  return best_distance <= tolerated ? best : std::string_view{};
}

std::string listed(const std::vector<std::string_view>& words, const char* last_joint) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? last_joint : ", ";
    text += words[i];
  }
  return text;
}

std::string remedy_for_unknown_key(std::string_view table, std::string_view key) {
  const auto& known = keys_of(table);
  for (auto candidate : known) {
    const auto unit = unit_of(candidate);
    if (unit.empty()) continue;
    const auto stem = candidate.substr(0, candidate.size() - unit.size());
    if (key == stem)
      return "the key of a value includes its unit: write " + std::string(candidate) + " and give the value in " +
             (unit == "_per_Pa" ? "1/Pa" : std::string(unit.substr(1)));
    if (key.starts_with(stem) && key.size() > stem.size() && key[stem.size()] == '_' && key.size() <= stem.size() + 5)
      return "values are in SI units: write " + std::string(candidate) + " and convert the value";
  }
  if (table == "material" || key.starts_with("material"))
    if (nearest(key, known).empty())
      return "remove it: materials are elastic and isotropic, without mass; [[region]] gives a part another one" +
             (table == "material" ? "; keys are " + listed(known, " and ") : "");
  if (const auto near = nearest(key, known); !near.empty()) return "did you mean " + std::string(near) + "?";
  for (const auto candidate : known)
    if (candidate.ends_with("_" + std::string(key)) ||
        candidate.ends_with("_" + std::string(key) + std::string(unit_of(candidate))))
      return "did you mean " + std::string(candidate) + "?";
  for (const auto& other : tables())
    if (!other.name.starts_with("selector.") &&
        std::find(other.keys.begin(), other.keys.end(), key) != other.keys.end())
      return "move it to " + bracketed(other.name) + ", where it belongs";
  return "remove it; the keys of " + bracketed(table) + " are " + listed(known, " and ");
}

std::vector<std::string_view> shape_keys(Shape shape) {
  const Scene none;
  Scene scene;
  scene.mesh.shape = shape;
  scene.mesh = with_standard_sizes(scene.mesh);
  std::vector<std::string_view> names;
  for (const auto& key : key_rows())
    if (key.section == "mesh" && key.name != "shape" && key.name != "target_nodes" && key.text(scene) != key.text(none))
      names.push_back(key.name);
  return names;
}

}  // namespace scene_detail

std::vector<std::string> scene_keys() {
  std::vector<std::string> keys;
  for (const auto& table : scene_detail::tables())
    for (auto key : table.keys)
      keys.push_back((table.name.empty() ? "" : std::string(table.name) + ".") + std::string(key));
  return keys;
}

namespace {

// The tables of keys in formats/scene.md.

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

/// The keys that are hashed, or those that are not: one "key = value" per line, those of regions with their number.
std::string lines_of(const Scene& scene, bool hashed) {
  std::string lines;
  const auto add = [&](const std::string& section, const auto& key, const std::string& text) {
    lines.append(section).append(".").append(key).append(" = ").append(text).append("\n");
  };
  for (const auto& key : scene_detail::key_rows())
    if (key.is_hashed == hashed && !key.section.empty() && key.section != "region")
      add(std::string(key.section), key.name, key.text(scene));
  for (std::size_t i = 0; i < scene.regions.size(); ++i) {
    const std::string section = "region " + std::to_string(i + 1);
    Scene one;
    one.regions = {scene.regions[i]};
    for (const auto& key : scene_detail::key_rows())
      if (key.is_hashed == hashed && key.section == "region") add(section, key.name, key.text(one));
    const Material& m = scene.regions[i].material;
    for (std::size_t p = 0; hashed && p < m.parameters.size(); ++p)
      add(section, m.law->parameters[p].key, scene_detail::shortest(m.parameters[p]));
  }
  return lines;
}

}  // namespace

std::string physics_summary(const Scene& scene) { return lines_of(scene, true); }
std::string other_settings(const Scene& scene) { return lines_of(scene, false); }
std::string physics_hash(const Scene& scene) { return hash_of(physics_summary(scene)); }

std::string scene_key_tables() {
  std::string blocks;
  for (const auto section : scene_detail::keys_of(""))
    if (section != "title" && section != "material")  // the keys of [material] are those of the laws
      blocks += block(std::string(section), section_table(section)) + '\n';
  return blocks + block("shapes", shape_table());
}

}  // namespace phynness
