// [nodes]: words and selector tables that select nodes of the mesh.
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>

#include "scene_keys.hpp"
#include "scene_sections.hpp"
#include "selectors.hpp"

namespace phynness::scene_detail {
namespace {

/// Names of the selectors that are words, or of the selectors that are tables.
std::vector<std::string_view> names_of(bool words) {
  std::vector<std::string_view> names;
  for (const auto& kind : selector_kinds())
    if ((kind.form == SelectorForm::word) == words) names.push_back(kind.name);
  return names;
}

const SelectorKind& kind_named(std::string_view name) {
  return *std::find_if(selector_kinds().begin(), selector_kinds().end(),
                       [&](const SelectorKind& kind) { return kind.name == name; });
}

NodeChoice parse_word(const toml::node& node, const std::string& word, const SceneTable& nodes, std::string_view key) {
  const auto names = names_of(true);
  if (std::find(names.begin(), names.end(), word) == names.end()) {
    const auto near = nearest(word, names);
    refuse(nodes.where(node), nodes.label(key) + " is not a known selection", "\"" + word + "\"",
           near.empty() ? "write one of " + listed(names) + ", or a selector table such as { sphere = { ... } }"
                        : "did you mean \"" + std::string(near) + "\"?");
  }
  return kind_named(word).parse(nodes);
}

/// The selector of a table such as { sphere = { ... }, surface_only = true }.
NodeChoice parse_table(const toml::node& node, const SceneTable& table, const SceneTable& nodes, std::string_view key) {
  std::string_view name;
  for (const auto candidate : names_of(false)) {
    if (!table.has(candidate)) continue;
    if (!name.empty())
      refuse(nodes.where(node), nodes.label(key) + " has two selectors in the same table", shown(node),
             "for their union write one table for each, [{ " + std::string(name) + " = ... }, { " +
                 std::string(candidate) + " = ... }]; for the nodes in both, { intersection = [ ... ] } of the two");
    name = candidate;
  }
  if (name.empty())
    refuse(nodes.where(node), nodes.label(key) + " has a selector without a shape", shown(node),
           "add one of " + listed(names_of(false)));
  const SelectorKind& kind = kind_named(name);
  for (const auto& other : selector_kinds())
    for (const auto more : other.form == SelectorForm::value ? other.keys : std::vector<std::string_view>{})
      if (table.has(more) && kind.keys != other.keys)
        table.reject(more, "cannot be combined with " + std::string(name),
                     "it belongs to spacing_m, spacing and count; combine others by { intersection = [ ... ] }");
  if (kind.form == SelectorForm::value) return kind.parse(table);
  const auto* inner = table.find(name)->as_table();
  if (!inner)
    table.reject(name, "must be a table", "write " + std::string(name) + " = { ... } with " + listed(kind.keys, ", "));
  return kind.parse(SceneTable(*inner, "selector." + std::string(name), table.file()));
}

Selector parse_selector(const toml::node& node, const SceneTable& nodes, std::string_view key) {
  Selector s;
  if (const auto* word = node.as_string()) {
    s.choice = std::make_shared<const NodeChoice>(parse_word(node, word->get(), nodes, key));
  } else if (const auto* inner = node.as_table()) {
    const SceneTable table(*inner, "selector", nodes.file());
    s.choice = std::make_shared<const NodeChoice>(parse_table(node, table, nodes, key));
    s.surface_only = table.flag_or("surface_only", false);
  } else {
    refuse(nodes.where(node), nodes.label(key) + " must be text, a selector table or an array of them", shown(node),
           "write \"surface\", or { sphere = { ... } }, or an array of selectors");
  }
  s.where = nodes.where(node);
  return s;
}

void check_fixed(const Selector& selector) {
  if (selector.choice->needs_fixed)
    refuse(selector.where, "[nodes] fixed cannot use a selection that depends on the fixed nodes",
           selector.choice->description,
           "select the fixed nodes by a box, sphere, plane, half_space, group or list of nodes");
  if (selector.choice->selects_all)
    refuse(selector.where, "[nodes] fixed selects all nodes, so that no node can move", selector.choice->description,
           "fix a part of the body only");
}

}  // namespace

Selection parse_selection(const toml::node& node, const SceneTable& holder, std::string_view key) {
  Selection selection;
  if (const auto* list = node.as_array()) {
    if (list->empty())
      refuse(holder.where(node), holder.label(key) + " is an empty list, which selects no node", "[]",
             key == "fixed" ? "select at least one node; without fixed nodes the body can move freely"
                            : "select at least one node, or remove the key");
    for (const auto& item : *list) selection.push_back(parse_selector(item, holder, key));
  } else {
    selection.push_back(parse_selector(node, holder, key));
  }
  return selection;
}

Selection parse_selection(const SceneTable& nodes, std::string_view key) {
  Selection selection = parse_selection(*nodes.find(key), nodes, key);
  if (key == "fixed") std::for_each(selection.begin(), selection.end(), check_fixed);
  return selection;
}

Vec3 parse_position(const SceneTable& table, const std::string& stem, bool& fraction) {
  const std::string in_metres = stem + "_m", in_fractions = stem + "_fraction";
  if (table.has(in_metres) && table.has(in_fractions))
    table.reject(in_fractions, "cannot be combined with " + in_metres, "keep one of the two");
  fraction = table.has(in_fractions);
  const auto value = fraction ? table.vector(in_fractions, fractions) : table.vector(in_metres, metres);
  if (!value)
    table.missing(in_metres, "",
                  "add " + in_metres + " = [x, y, z], or " + in_fractions + " (0 to 1 across the bounding box)");
  return *value;
}

Vec3 parse_normal(const SceneTable& table) {
  auto normal = table.vector("normal", {-1e6, 1e6});
  if (!normal) table.missing("normal", "", "add normal = [x, y, z], a direction of any length");
  const double norm = std::hypot((*normal)[0], (*normal)[1], (*normal)[2]);
  if (!(norm > 0)) table.reject("normal", "has the length 0", "give a vector that is not zero");
  for (double& x : *normal) x /= norm;
  return *normal;
}

}  // namespace phynness::scene_detail

namespace phynness {

Selection parse_selection(const std::string& text) {
  const toml::table root = scene_detail::parse_toml("output = " + text, "the selection");
  auto selection = scene_detail::parse_selection({root, "nodes", ""}, "output");
  for (auto& selector : selection) selector.where = {};
  return selection;
}

}  // namespace phynness
