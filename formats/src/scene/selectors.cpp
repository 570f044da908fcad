// The selectors: their keys in a scene, and their texts in messages and in the physics hash.
#include "selectors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/printable.hpp>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness::scene_detail {
namespace {

/// Reads a position under the key `stem`_m or `stem`_fraction, one of which must be given.
/// @return its text behind the stem
std::string read_point(const SceneTable& table, const std::string& stem, Selector& s) {
  const std::string in_metres = stem + "_m", in_fractions = stem + "_fraction";
  if (table.has(in_metres) && table.has(in_fractions))
    table.reject(in_fractions, "cannot be combined with " + in_metres, "keep one of the two");
  s.in_fractions = table.has(in_fractions);
  const auto value = s.in_fractions ? table.vector(in_fractions, fractions) : table.vector(in_metres, metres);
  if (!value)
    table.missing(in_metres, "",
                  "add " + in_metres + " = [x, y, z], or " + in_fractions + " (0 to 1 across the bounding box)");
  s.point = *value;
  return (s.in_fractions ? in_fractions : in_metres) + " = " + exact_text(s.point);
}
std::string shown_point(const Selector& s) {
  return shown_text(s.point) + (s.in_fractions ? " (fractions of the bounding box)" : " m");
}

/// Reads the key `normal`, a vector of any length except zero.
void read_normal(const SceneTable& table, Selector& s) {
  const auto normal = table.vector("normal", {-1e6, 1e6});
  if (!normal) table.missing("normal", "", "add normal = [x, y, z], a direction of any length");
  const double norm = std::hypot((*normal)[0], (*normal)[1], (*normal)[2]);
  if (!(norm > 0)) table.reject("normal", "has the length 0", "give a vector that is not zero");
  for (std::size_t k = 0; k < 3; ++k) s.other[k] = (*normal)[k] / norm;
}

void read_box(const SceneTable& table, std::string_view, Selector& s) {
  const bool metric = table.has("min_m") || table.has("max_m");
  s.in_fractions = table.has("min_fraction") || table.has("max_fraction");
  if (metric && s.in_fractions)
    table.reject(table.has("min_fraction") ? "min_fraction" : "max_fraction",
                 "cannot be combined with corners in metres",
                 "give both corners in metres (min_m, max_m) or both as fractions (min_fraction, max_fraction)");
  const std::string first = s.in_fractions ? "min_fraction" : "min_m", last = s.in_fractions ? "max_fraction" : "max_m";
  const auto range = s.in_fractions ? fractions : metres;
  const auto a = table.vector(first, range), b = table.vector(last, range);
  if (!a) table.missing(first, "", "a box needs both corners: add " + first + " = [x, y, z]");
  if (!b) table.missing(last, "", "a box needs both corners: add " + last + " = [x, y, z]");
  for (std::size_t i = 0; i < 3; ++i)
    if ((*a)[i] > (*b)[i])
      table.reject(first, "is greater than " + last + ", so that the box is empty", "swap the two corners");
  s.point = *b;
  const std::string upper = shown_point(s);
  s.point = *a, s.other = *b;
  s.text = "box { " + first + " = " + exact_text(*a) + ", " + last + " = " + exact_text(*b) + " }";
  s.description = "box " + shown_text(*a) + " to " + upper;
}

void read_sphere(const SceneTable& table, std::string_view, Selector& s) {
  const auto center = read_point(table, "center", s);
  const auto radius = table.number("radius_m", length);
  if (!radius) table.missing("radius_m", "", "add radius_m in metres");
  s.length_m = *radius;
  s.text = "sphere { " + center + ", radius_m = " + shortest(*radius) + " }";
  s.description = "sphere at " + shown_point(s) + ", radius " + length_text(*radius);
}

void read_ellipsoid(const SceneTable& table, std::string_view, Selector& s) {
  const auto center = read_point(table, "center", s);
  const auto radii = table.vector("radii_m", length);
  if (!radii) table.missing("radii_m", "", "add radii_m = [x, y, z], half of its lengths along the axes, in metres");
  s.other = *radii;
  s.text = "ellipsoid { " + center + ", radii_m = " + exact_text(*radii) + " }";
  s.description = "ellipsoid at " + shown_point(s) + ", radii " + shown_text(*radii) + " m";
}

void read_plane(const SceneTable& table, std::string_view, Selector& s) {
  const auto point = read_point(table, "point", s);
  read_normal(table, s);
  s.length_m = table.number_or("tolerance_m", 1e-6, length);
  s.text = "plane { " + point + ", normal = " + exact_text(s.other) + ", tolerance_m = " + shortest(s.length_m) + " }";
  s.description =
      "plane through " + shown_point(s) + ", normal " + shown_text(s.other) + ", tolerance " + length_text(s.length_m);
}

void read_half_space(const SceneTable& table, std::string_view, Selector& s) {
  const auto point = read_point(table, "point", s);
  read_normal(table, s);
  s.text = "half_space { " + point + ", normal = " + exact_text(s.other) + " }";
  s.description = "half space below " + shown_point(s) + ", normal " + shown_text(s.other);
}

void read_group(const SceneTable& table, std::string_view, Selector& s) {
  s.group = *table.text("group");
  if (s.group.empty()) table.reject("group", "is empty", "give the name of a physical group of the mesh file");
  s.text = "group \"" + s.group + "\"";
  s.description = "group '" + s.group + "'";
}

void read_nodes(const SceneTable& table, std::string_view, Selector& s) {
  const auto* list = table.find("nodes")->as_array();
  if (!list) table.reject("nodes", "must be an array of node numbers", "write nodes = [0, 5, 7]");
  if (list->empty()) table.reject("nodes", "is an empty list", "give at least one node, or remove the selector");
  std::string numbers;
  for (const auto& item : *list) {
    const auto* number = item.as_integer();
    if (!number || number->get() < 0 || number->get() > std::numeric_limits<std::int32_t>::max())
      refuse(table.where(item), table.label("nodes") + " must contain integers of at least 0", shown(item),
             "give node numbers, which start with 0, in the order of the mesh file");
    s.nodes.push_back(static_cast<std::int32_t>(number->get()));
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(s.nodes.back());
  }
  s.text = "nodes [" + numbers + "]";
  s.description = "a list of " + std::to_string(s.nodes.size()) + " nodes";
}

void read_nearest(const SceneTable& table, std::string_view, Selector& s) {
  s.text = "nearest { " + read_point(table, "point", s) + " }";
  s.description = "node nearest to " + shown_point(s);
}

/// The descriptions of selections, each in brackets.
std::string described(const std::vector<Selection>& selections, const char* between = "") {
  std::string all;
  for (const auto& selection : selections) {
    all += all.empty() ? "[" : std::string("]") + between + "[";
    for (const auto& s : selection) all += (&s == &selection.front() ? "" : " or ") + s.description;
  }
  return all + "]";
}

/// A selector whose value is an array of selections.
void read_several(const SceneTable& table, std::string_view key, Selector& s) {
  const std::string name(key);
  const auto* list = table.find(name)->as_array();
  if (!list || list->size() < 2)
    table.reject(name, "must be an array of at least two selections",
                 "write for example " + name + " = [{ sphere = { ... } }, \"free-surface\"]");
  std::string texts;
  for (const auto& item : *list) {
    s.of.push_back(parse_selection(item, table, name));
    texts.append(texts.empty() ? "" : ", ").append(selection_text(s.of.back()));
  }
  s.text = name + " { " + texts + " }";
  s.description = name + " of " + described(s.of, " and ");
}

void read_not(const SceneTable& table, std::string_view, Selector& s) {
  s.of = {parse_selection(*table.find("not"), table, "not")};
  s.text = "not { " + selection_text(s.of[0]) + " }";
  s.description = "not " + described(s.of);
}

void read_near(const SceneTable& table, std::string_view, Selector& s) {
  if (!table.has("to")) table.missing("to", "", "add a selection, such as to = \"fixed\"");
  s.of = {parse_selection(*table.find("to"), table, "to")};
  const auto distance_m = table.number("distance_m", length);
  if (!distance_m) table.missing("distance_m", "", "add distance_m in metres");
  s.length_m = *distance_m;
  s.text = "near { to = " + selection_text(s.of[0]) + ", distance_m = " + shortest(s.length_m) + " }";
  s.description = "within " + length_text(s.length_m) + " of " + described(s.of);
}

/// Nodes that are spread evenly over a part of the surface, at given distances, at those that the tool needs, or a
/// given number of them.
void read_spread(const SceneTable& table, std::string_view, Selector& s) {
  if (const auto* given = table.find("spacing_m"); given && given->is_string())
    table.reject("spacing_m", "must be a number", "write metres without quotes, or the other key: spacing = \"auto\"");
  s.length_m = table.number_or("spacing_m", 0, length);
  s.count = table.integer("count", 1, std::numeric_limits<std::int32_t>::max()).value_or(0);
  if (const auto* given = table.find("spacing"); given && given->value_or(std::string()) != "auto")
    table.reject("spacing", "must be \"auto\"",
                 "write spacing = \"auto\", or the other key in metres: spacing_m = 0.01");
  s.of = {table.has("within") ? parse_selection(*table.find("within"), table, "within") : Selection(1)};
  s.from_fixed_m = table.number_or("from_fixed_m", 0, length);
  const std::string size = s.length_m > 0 ? "spacing_m = " + shortest(s.length_m)
                           : s.count > 0  ? "count = " + std::to_string(s.count)
                                          : "spacing = auto";
  const std::string distance = s.from_fixed_m > 0 ? ", from_fixed_m = " + shortest(s.from_fixed_m) : "";
  s.text = "spread { " + size + ", within = " + selection_text(s.of[0]) + distance + " }";
  s.description = "points with " + size + " on " + described(s.of) + distance;
}

}  // namespace

const std::vector<SelectorRow>& selector_rows() {
  using enum SelectorForm;
  using Kind = SelectorKind;
  static const std::vector<SelectorRow> rows = {
      {"box", Kind::box, table, {"min_m", "max_m", "min_fraction", "max_fraction"}, read_box},
      {"sphere", Kind::sphere, table, {"center_m", "center_fraction", "radius_m"}, read_sphere},
      {"ellipsoid", Kind::ellipsoid, table, {"center_m", "center_fraction", "radii_m"}, read_ellipsoid},
      {"plane", Kind::plane, table, {"point_m", "point_fraction", "normal", "tolerance_m"}, read_plane},
      {"half_space", Kind::half_space, table, {"point_m", "point_fraction", "normal"}, read_half_space},
      {"group", Kind::group, value, {}, read_group},
      {"nodes", Kind::nodes, value, {}, read_nodes},
      {"nearest", Kind::nearest, table, {"point_m", "point_fraction"}, read_nearest},
      {"surface", Kind::surface, word},
      {"free-surface", Kind::free_surface, word},
      {"free", Kind::free, word},
      {"fixed", Kind::fixed, word},
      {"all", Kind::all, word},
      {"intersection", Kind::intersection, value, {}, read_several},
      {"difference", Kind::difference, value, {}, read_several},
      {"not", Kind::complement, value, {}, read_not},
      {"near", Kind::near, table, {"to", "distance_m"}, read_near},
      {"spacing_m", Kind::spread, value, {}, read_spread},
      {"spacing", Kind::spread, value, {}, read_spread},
      {"count", Kind::spread, value, {}, read_spread}};
  return rows;
}

std::string selection_text(const Selection& selection) {
  std::string result;
  for (const auto& s : selection) result += (result.empty() ? "" : " + ") + s.text;
  return result;
}

}  // namespace phynness::scene_detail

namespace phynness {

bool spreads(const Selection& selection) {
  return std::ranges::any_of(selection, [](const Selector& s) {
    const bool combined = s.kind == SelectorKind::intersection || s.kind == SelectorKind::difference;
    return s.kind == SelectorKind::spread || (combined && std::ranges::any_of(s.of, spreads));
  });
}

double spacing_m(const Selection& selection) {
  for (const Selector& s : selection) {
    if (s.kind == SelectorKind::spread && s.length_m > 0) return s.length_m;
    for (const Selection& part : s.of)
      if (const double spacing = spacing_m(part); spacing > 0) return spacing;
  }
  return 0;
}

}  // namespace phynness
