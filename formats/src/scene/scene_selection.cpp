// [nodes]: words and selector tables that select nodes of the mesh.
#include <algorithm>

#include "scene_keys.hpp"
#include "scene_sections.hpp"
#include "selectors.hpp"

namespace phynness::scene_detail {
namespace {

/// Names of the selectors that are words, or of the selectors that are tables.
std::vector<std::string_view> names_of(bool words) {
  std::vector<std::string_view> names;
  for (const auto& row : selector_rows())
    if ((row.form == SelectorForm::word) == words) names.push_back(row.name);
  return names;
}

const SelectorRow& row_named(std::string_view name) {
  return *std::ranges::find(selector_rows(), name, &SelectorRow::name);
}

void parse_word(const toml::node& node, const std::string& word, const SceneTable& nodes, std::string_view key,
                Selector& s) {
  const auto names = names_of(true);
  if (std::find(names.begin(), names.end(), word) == names.end()) {
    const auto near = nearest(word, names);
    refuse(nodes.where(node), nodes.label(key) + " is not a known selection", "\"" + word + "\"",
           near.empty() ? "write one of " + listed(names) + ", or a selector table such as { sphere = { ... } }"
                        : "did you mean \"" + std::string(near) + "\"?");
  }
  s.kind = row_named(word).kind;
  s.text = word;
  s.description = '"' + word + '"';
}

/// The selector of a table such as { sphere = { ... }, surface_only = true }.
void parse_table(const toml::node& node, const SceneTable& table, const SceneTable& nodes, std::string_view key,
                 Selector& s) {
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
  const SelectorRow& row = row_named(name);
  s.kind = row.kind;
  for (const auto more : keys_beside_values)
    if (table.has(more) && row.kind != SelectorKind::spread)
      table.reject(more, "cannot be combined with " + std::string(name),
                   "it belongs to spacing_m, spacing and count; combine others by { intersection = [ ... ] }");
  if (row.form == SelectorForm::value) return row.read(table, name, s);
  const auto* inner = table.find(name)->as_table();
  if (!inner)
    table.reject(name, "must be a table", "write " + std::string(name) + " = { ... } with " + listed(row.keys, ", "));
  row.read(SceneTable(*inner, "selector." + std::string(name), table.file()), name, s);
}

Selector parse_selector(const toml::node& node, const SceneTable& nodes, std::string_view key) {
  Selector s;
  if (const auto* word = node.as_string()) {
    parse_word(node, word->get(), nodes, key, s);
  } else if (const auto* inner = node.as_table()) {
    const SceneTable table(*inner, "selector", nodes.file());
    parse_table(node, table, nodes, key, s);
    s.surface_only = table.flag("surface_only");
    if (s.surface_only) s.text += " surface_only", s.description += ", surface nodes only";
  } else {
    refuse(nodes.where(node), nodes.label(key) + " must be text, a selector table or an array of them", shown(node),
           "write \"surface\", or { sphere = { ... } }, or an array of selectors");
  }
  s.where = nodes.where(node);
  return s;
}

bool needs_fixed(const Selector& s) {
  using enum SelectorKind;
  return s.kind == free_surface || s.kind == free || s.kind == fixed || s.from_fixed_m > 0 ||
         std::ranges::any_of(s.of, [](const Selection& part) { return std::ranges::any_of(part, needs_fixed); });
}

void check_fixed(const Selector& selector) {
  if (needs_fixed(selector))
    refuse(selector.where, "[nodes] fixed cannot use a selection that depends on the fixed nodes", selector.description,
           "select the fixed nodes by a box, sphere, plane, half_space, group or list of nodes");
  if (selector.kind == SelectorKind::all)
    refuse(selector.where, "[nodes] fixed selects all nodes, so that no node can move", selector.description,
           "fix a part of the body only");
}

/// Cells are in a place, or in a group of the file.
void check_cells(const Selector& s) {
  using enum SelectorKind;
  const bool combined = s.kind == intersection || s.kind == difference || s.kind == complement;
  const bool place =
      s.kind == box || s.kind == sphere || s.kind == ellipsoid || s.kind == plane || s.kind == half_space;
  if (s.surface_only || !(combined || place || s.kind == group || s.kind == all || s.kind == near))
    refuse(s.where, "[[region]] cells selects nodes, but a region is made of cells", s.description,
           "select a place or a group, or write { near = { to = ..., distance_m = ... } }, which is all cells within a "
           "distance of nodes");
  if (combined)
    for (const Selection& part : s.of) std::ranges::for_each(part, check_cells);
}

}  // namespace

Selection parse_cells(const SceneTable& region, std::string_view key) {
  Selection selection = parse_selection(*region.find(key), region, key);
  std::ranges::for_each(selection, check_cells);
  return selection;
}

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

}  // namespace phynness::scene_detail
