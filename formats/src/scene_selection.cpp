// [nodes]: words and selector tables that choose nodes of the mesh.
#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness::scene_detail {
namespace {

constexpr Range metres{-1e3, 1e3};
constexpr Range fractions{-10, 10};
constexpr Range length{0, 1e3, true, false};

const std::vector<std::string_view> shapes = {"box",   "sphere", "plane",  "half_space",
                                              "group", "nodes",  "nearest"};

void parse_box(const SceneTable& table, Selector& s) {
  const bool metric = table.has("min_m") || table.has("max_m");
  const bool relative = table.has("min_fraction") || table.has("max_fraction");
  if (metric && relative)
    table.reject(
        table.has("min_fraction") ? "min_fraction" : "max_fraction", "stands beside corners in metres",
        "give both corners in metres (min_m, max_m) or both as fractions (min_fraction, max_fraction)");
  s.fraction = relative;
  const std::string low = relative ? "min_fraction" : "min_m", high = relative ? "max_fraction" : "max_m";
  const auto range = relative ? fractions : metres;
  const auto a = table.vector(low, range), b = table.vector(high, range);
  if (!a) table.missing(low, "", "a box needs both corners: add " + low + " = [x, y, z]");
  if (!b) table.missing(high, "", "a box needs both corners: add " + high + " = [x, y, z]");
  for (std::size_t i = 0; i < 3; ++i)
    if ((*a)[i] > (*b)[i])
      table.reject(low, "lies above " + high + ", so that the box is empty", "swap the two corners");
  s.a = *a, s.b = *b;
}

void parse_node_list(const SceneTable& table, Selector& s) {
  const auto& node = *table.find("nodes");
  const auto* list = node.as_array();
  if (!list) table.reject("nodes", "must be an array of node numbers", "write nodes = [0, 5, 7]");
  if (list->empty())
    table.reject("nodes", "is an empty list", "name at least one node, or remove the selector");
  for (const auto& item : *list) {
    const auto* number = item.as_integer();
    if (!number || number->get() < 0 || number->get() > std::numeric_limits<std::int32_t>::max())
      refuse(table.where(item), table.label("nodes") + " must hold node numbers, 0 or greater", shown(item),
             "number nodes from 0 in the order of the mesh file");
    s.nodes.push_back(static_cast<std::int32_t>(number->get()));
  }
}

Selector parse_shape(const SceneTable& table, std::string_view shape) {
  Selector s;
  if (shape == "nodes") {
    s.kind = Selector::Kind::nodes;
    parse_node_list(table, s);
    return s;
  }
  if (shape == "group") {
    s.kind = Selector::Kind::group;
    s.group = *table.text("group");
    if (s.group.empty()) table.reject("group", "is empty", "name a physical group of the mesh file");
    return s;
  }
  const auto* inner = table.find(shape)->as_table();
  if (!inner)
    table.reject(shape, "must be a table",
                 "write " + std::string(shape) + " = { ... } with " +
                     listed(keys_of("selector." + std::string(shape)), ", "));
  const SceneTable t(*inner, "selector." + std::string(shape), table.file());
  if (shape == "box") {
    s.kind = Selector::Kind::box;
    parse_box(t, s);
  } else if (shape == "sphere") {
    s.kind = Selector::Kind::sphere;
    s.a = parse_position(t, "center", s.fraction);
    const auto radius = t.number("radius_m", length);
    if (!radius) t.missing("radius_m", "", "add radius_m in metres");
    s.radius_m = *radius;
  } else if (shape == "nearest") {
    s.kind = Selector::Kind::nearest;
    s.a = parse_position(t, "point", s.fraction);
  } else {
    s.kind = shape == "plane" ? Selector::Kind::plane : Selector::Kind::half_space;
    s.a = parse_position(t, "point", s.fraction);
    s.b = parse_normal(t);
    constexpr double default_tolerance_m = 1e-6;
    if (shape == "plane") s.radius_m = t.number_or("tolerance_m", default_tolerance_m, length);
  }
  return s;
}

Selector parse_word(const toml::node& node, const std::string& word, const SceneTable& nodes,
                    std::string_view key) {
  static const std::vector<std::pair<std::string_view, Selector::Kind>> words = {
      {"surface", Selector::Kind::surface},
      {"free-surface", Selector::Kind::free_surface},
      {"free", Selector::Kind::free_nodes},
      {"all", Selector::Kind::all}};
  std::vector<std::string_view> names;
  Selector s;
  for (const auto& [name, kind] : words) {
    if (word == name) {
      s.kind = kind;
      const bool needs_fixed = kind == Selector::Kind::free_surface || kind == Selector::Kind::free_nodes;
      if (key == "fixed" && needs_fixed)
        refuse(nodes.where(node), "[nodes] fixed cannot be chosen by what is free", "\"" + word + "\"",
               "select the fixed nodes by a box, sphere, plane, half_space, group or list of nodes");
      if (key == "fixed" && kind == Selector::Kind::all)
        refuse(nodes.where(node), "[nodes] fixed leaves no node to move", "\"" + word + "\"",
               "fix a part of the body only");
      return s;
    }
    names.push_back(name);
  }
  const auto near = nearest(word, names);
  refuse(nodes.where(node), nodes.label(key) + " names no selection", "\"" + word + "\"",
         near.empty() ? "write one of " + listed(names) + ", or a selector table such as { sphere = { ... } }"
                      : "did you mean \"" + std::string(near) + "\"?");
}

Selector parse_selector(const toml::node& node, const SceneTable& nodes, std::string_view key) {
  Selector s;
  if (const auto* word = node.as_string()) {
    s = parse_word(node, word->get(), nodes, key);
  } else if (const auto* inner = node.as_table()) {
    const SceneTable table(*inner, "selector", nodes.file());
    std::string_view shape;
    for (auto candidate : shapes) {
      if (!table.has(candidate)) continue;
      if (!shape.empty())
        refuse(nodes.where(node), nodes.label(key) + " has two selectors in one table", shown(node),
               "write one table for each: [{ " + std::string(shape) + " = ... }, { " +
                   std::string(candidate) + " = ... }]");
      shape = candidate;
    }
    if (shape.empty())
      refuse(nodes.where(node), nodes.label(key) + " has a selector without a shape", shown(node),
             "add one of " + listed(shapes));
    s = parse_shape(table, shape);
    s.surface_only = table.flag_or("surface_only", false);
  } else {
    refuse(nodes.where(node), nodes.label(key) + " must be text, a selector table or an array of them",
           shown(node), "write \"surface\", or { sphere = { ... } }, or an array of such");
  }
  s.where = nodes.where(node);
  return s;
}

Selection parse_selection(const SceneTable& nodes, std::string_view key) {
  const auto& node = *nodes.find(key);
  Selection selection;
  if (const auto* list = node.as_array()) {
    if (list->empty())
      nodes.reject(key, "is an empty list, which selects no node",
                   key == "fixed" ? "select at least one node; a body that is nowhere fixed floats away"
                                  : "select at least one node, or remove the key to take its default");
    for (const auto& item : *list) selection.push_back(parse_selector(item, nodes, key));
  } else {
    selection.push_back(parse_selector(node, nodes, key));
  }
  return selection;
}

}  // namespace

Vec3 parse_position(const SceneTable& table, const std::string& stem, bool& fraction) {
  const std::string in_metres = stem + "_m", in_fractions = stem + "_fraction";
  if (table.has(in_metres) && table.has(in_fractions))
    table.reject(in_fractions, "stands beside " + in_metres, "keep one of the two");
  fraction = table.has(in_fractions);
  const auto value = fraction ? table.vector(in_fractions, fractions) : table.vector(in_metres, metres);
  if (!value)
    table.missing(
        in_metres, "",
        "add " + in_metres + " = [x, y, z], or " + in_fractions + " (0 to 1 across the bounding box)");
  return *value;
}

Vec3 parse_normal(const SceneTable& table) {
  auto normal = table.vector("normal", {-1e6, 1e6});
  if (!normal) table.missing("normal", "", "add normal = [x, y, z], a direction of any length");
  const double norm = std::hypot((*normal)[0], (*normal)[1], (*normal)[2]);
  if (!(norm > 0)) table.reject("normal", "has no direction", "give a vector that is not zero");
  for (double& x : *normal) x /= norm;
  return *normal;
}

void parse_nodes(const SceneTable& table, Scene& scene) {
  if (!table.has("fixed"))
    table.missing("fixed", ": a body that is nowhere fixed floats away and its system is singular",
                  "add fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } } or another "
                  "selection");
  const auto read = [&](std::string_view key, Selection& selection, SourceLocation& where) {
    where = table.where(key);
    if (table.has(key)) {
      selection = parse_selection(table, key);
    } else {
      Selector s;
      s.kind = Selector::Kind::free_surface;
      s.where = where;
      selection = {s};
    }
  };
  read("fixed", scene.fixed, scene.fixed_where);
  read("active", scene.active, scene.active_where);
  read("output", scene.output, scene.output_where);
}

}  // namespace phynness::scene_detail
