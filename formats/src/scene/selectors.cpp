// The simple selectors: their keys in a scene, their texts in messages and in the physics hash, and the nodes that they
// select.
#include "selectors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>

#include "scene_sections.hpp"

namespace phynness::scene_detail {
namespace {

using Vector = Eigen::RowVector3d;

Vector to_row(const Vec3& v) { return to_eigen(v).transpose(); }

const char* units(bool fraction) { return fraction ? " (fractions of the bounding box)" : " m"; }

/// A point in metres or in fractions of the bounding box.
struct Place {
  Vec3 x{};
  bool fraction = false;

  Vector in(const SelectableBody& body) const {
    return fraction ? Vector(to_row(body.low) + to_row(x).cwiseProduct(to_row(body.high) - to_row(body.low)))
                    : to_row(x);
  }
  /// The text that follows the stem of its key.
  std::string text() const { return (fraction ? "_fraction = " : "_m = ") + exact_text(x); }
  const char* units() const { return scene_detail::units(fraction); }
};

Place parse_place(const SceneTable& table, const std::string& stem) {
  Place place;
  place.x = parse_position(table, stem, place.fraction);
  return place;
}

NodeList without_fixed(const SelectableBody& body, const NodeList& nodes) {
  NodeList free;
  std::set_difference(nodes.begin(), nodes.end(), body.fixed.begin(), body.fixed.end(), std::back_inserter(free));
  return free;
}

/// How far each point lies outside of a part of space [m]; 0 inside.
using Distance = std::function<double(const Vector&)>;

/// A selector of what lies in a part of space. @param in_fractions  of the bounding box, for messages
NodeChoice region(const std::string& text, const std::string& description, bool in_fractions,
                  const std::function<Distance(const SelectableBody& body)>& outside_of) {
  NodeChoice choice{text, description};
  choice.pick = [=](const SelectableBody& body, const PickRequest& request) {
    const Distance outside = outside_of(body);
    NodeList nodes;
    for (const std::int32_t i : request.candidates)
      if (outside(body.mesh.nodes.row(i)) <= body.slack_m) nodes.push_back(i);
    return nodes;
  };
  choice.remedy_if_empty = [=](const SelectableBody& body, const PickRequest& request) {
    const Distance outside = outside_of(body);
    double best = std::numeric_limits<double>::infinity();
    std::int32_t nearest = -1;
    for (const std::int32_t i : body.surface)
      if (const double d = outside(body.mesh.nodes.row(i)); d < best) best = d, nearest = i;
    if (nearest < 0) return NodeChoice().remedy_if_empty(body, request);
    const Vector x = body.mesh.nodes.row(nearest), low = to_row(body.low), size = to_row(body.high) - low;
    Vec3 shown{x(0), x(1), x(2)};
    if (in_fractions)
      for (int k = 0; k < 3; ++k) shown[k] = size(k) > 0 ? (x(k) - low(k)) / size(k) : 0;
    return "the nearest node of the surface is " + std::to_string(nearest) + " at " + shown_text(shown) +
           units(in_fractions) + ", " + length_text(best) + " outside of it: move or widen it so far";
  };
  return choice;
}

NodeChoice box(const SceneTable& table) {
  const bool metric = table.has("min_m") || table.has("max_m");
  const bool relative = table.has("min_fraction") || table.has("max_fraction");
  if (metric && relative)
    table.reject(table.has("min_fraction") ? "min_fraction" : "max_fraction",
                 "cannot be combined with corners in metres",
                 "give both corners in metres (min_m, max_m) or both as fractions (min_fraction, max_fraction)");
  const std::string first = relative ? "min_fraction" : "min_m", last = relative ? "max_fraction" : "max_m";
  const auto range = relative ? fractions : metres;
  const auto a = table.vector(first, range), b = table.vector(last, range);
  if (!a) table.missing(first, "", "a box needs both corners: add " + first + " = [x, y, z]");
  if (!b) table.missing(last, "", "a box needs both corners: add " + last + " = [x, y, z]");
  for (std::size_t i = 0; i < 3; ++i)
    if ((*a)[i] > (*b)[i])
      table.reject(first, "is greater than " + last + ", so that the box is empty", "swap the two corners");
  const Place low{*a, relative}, high{*b, relative};
  return region("box { min" + low.text() + ", max" + high.text() + " }",
                "box " + shown_text(low.x) + " to " + shown_text(high.x) + low.units(), relative,
                [=](const SelectableBody& body) -> Distance {
                  return [from = low.in(body), to = high.in(body)](const Vector& x) {
                    return (from - x).cwiseMax(x - to).cwiseMax(0).norm();
                  };
                });
}

NodeChoice sphere(const SceneTable& table) {
  const Place center = parse_place(table, "center");
  const auto radius = table.number("radius_m", length);
  if (!radius) table.missing("radius_m", "", "add radius_m in metres");
  return region("sphere { center" + center.text() + ", radius_m = " + shortest(*radius) + " }",
                "sphere at " + shown_text(center.x) + center.units() + ", radius " + length_text(*radius),
                center.fraction, [=, r = *radius](const SelectableBody& body) -> Distance {
                  return [=, c = center.in(body)](const Vector& x) { return std::max((x - c).norm() - r, 0.0); };
                });
}

/// The signed distance from a plane. @param normal  unit
Distance above_plane(const SelectableBody& body, const Place& point, const Vec3& normal) {
  return [p = point.in(body), n = Vector(to_row(normal).normalized())](const Vector& x) { return (x - p).dot(n); };
}

NodeChoice plane(const SceneTable& table) {
  const Place point = parse_place(table, "point");
  const Vec3 normal = parse_normal(table);
  const double tolerance_m = table.number_or("tolerance_m", 1e-6, length);
  return region("plane { point" + point.text() + ", normal = " + exact_text(normal) +
                    ", tolerance_m = " + shortest(tolerance_m) + " }",
                "plane through " + shown_text(point.x) + point.units() + ", normal " + shown_text(normal) +
                    ", tolerance " + length_text(tolerance_m),
                point.fraction, [=](const SelectableBody& body) -> Distance {
                  return [=, above = above_plane(body, point, normal)](const Vector& x) {
                    return std::max(std::abs(above(x)) - tolerance_m, 0.0);
                  };
                });
}

NodeChoice half_space(const SceneTable& table) {
  const Place point = parse_place(table, "point");
  const Vec3 normal = parse_normal(table);
  return region("half_space { point" + point.text() + ", normal = " + exact_text(normal) + " }",
                "half space below " + shown_text(point.x) + point.units() + ", normal " + shown_text(normal),
                point.fraction, [=](const SelectableBody& body) -> Distance {
                  return
                      [above = above_plane(body, point, normal)](const Vector& x) { return std::max(above(x), 0.0); };
                });
}

NodeChoice group(const SceneTable& table) {
  const std::string group = *table.text("group");
  if (group.empty()) table.reject("group", "is empty", "give the name of a physical group of the mesh file");
  return {"group \"" + group + "\"", "group '" + group + "'",
          [group](const SelectableBody& body, const PickRequest& request) {
            const auto& groups = body.mesh.groups;
            if (const auto found = groups.find(group); found != groups.end()) return found->second;
            std::string names;
            for (const auto& [known, nodes] : groups) names += (names.empty() ? "'" : ", '") + known + "'";
            throw input_error(request.place + "the mesh has no physical group for the " + request.nodes, group,
                              names.empty() ? "the mesh has no groups: select by box, sphere or plane"
                                            : "use one of the groups of the mesh: " + names);
          }};
}

NodeChoice numbered(const SceneTable& table) {
  const auto* list = table.find("nodes")->as_array();
  if (!list) table.reject("nodes", "must be an array of node numbers", "write nodes = [0, 5, 7]");
  if (list->empty()) table.reject("nodes", "is an empty list", "give at least one node, or remove the selector");
  NodeList nodes;
  std::string numbers;
  for (const auto& item : *list) {
    const auto* number = item.as_integer();
    if (!number || number->get() < 0 || number->get() > std::numeric_limits<std::int32_t>::max())
      refuse(table.where(item), table.label("nodes") + " must contain integers of at least 0", shown(item),
             "give node numbers, which start with 0, in the order of the mesh file");
    nodes.push_back(static_cast<std::int32_t>(number->get()));
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(nodes.back());
  }
  return {"nodes [" + numbers + "]", "a list of " + std::to_string(nodes.size()) + " nodes",
          [nodes](const SelectableBody& body, const PickRequest& request) {
            for (const std::int32_t node : nodes)
              if (node >= body.mesh.n_nodes())
                throw input_error(request.place + "a node number of the " + request.nodes + " is out of range",
                                  std::to_string(node),
                                  "give numbers from 0 to " + std::to_string(body.mesh.n_nodes() - 1));
            return nodes;
          }};
}

NodeChoice nearest_node(const SceneTable& table) {
  const Place point = parse_place(table, "point");
  return {"nearest { point" + point.text() + " }", "node nearest to " + shown_text(point.x) + point.units(),
          [point](const SelectableBody& body, const PickRequest& request) {
            const Vector x = point.in(body);
            double best = std::numeric_limits<double>::infinity();
            NodeList nearest;
            for (const std::int32_t i : request.candidates)
              if (const double d = (Vector(body.mesh.nodes.row(i)) - x).squaredNorm(); d < best)
                best = d, nearest = {i};
            return nearest;
          }};
}

/// A selector without keys.
struct WordRow {
  const char* name;
  NodeList (*pick)(const SelectableBody& body, const PickRequest& request);
  bool needs_fixed = false, selects_all = false;
};
constexpr WordRow free_surface_row{
    "free-surface", [](const SelectableBody& body, const PickRequest&) { return without_fixed(body, body.surface); },
    true};
constexpr WordRow words[] = {
    {"surface", [](const SelectableBody& body, const PickRequest&) { return body.surface; }},
    free_surface_row,
    {"free",
     [](const SelectableBody& body, const PickRequest& request) { return without_fixed(body, request.candidates); },
     true},
    {"fixed", [](const SelectableBody& body, const PickRequest&) { return body.fixed; }, true},
    {"all", [](const SelectableBody&, const PickRequest& request) { return request.candidates; }, false, true}};

NodeChoice choice_of(const WordRow& row) {
  NodeChoice choice{row.name, '"' + std::string(row.name) + '"', row.pick};
  choice.needs_fixed = row.needs_fixed;
  choice.selects_all = row.selects_all;
  return choice;
}

}  // namespace

const std::vector<SelectorKind>& selector_kinds() {
  static const std::vector<SelectorKind> kinds = [] {
    using enum SelectorForm;
    std::vector<SelectorKind> all = {{"box", table, {"min_m", "max_m", "min_fraction", "max_fraction"}, box},
                                     {"sphere", table, {"center_m", "center_fraction", "radius_m"}, sphere},
                                     {"plane", table, {"point_m", "point_fraction", "normal", "tolerance_m"}, plane},
                                     {"half_space", table, {"point_m", "point_fraction", "normal"}, half_space},
                                     {"group", value, {}, group},
                                     {"nodes", value, {}, numbered},
                                     {"nearest", table, {"point_m", "point_fraction"}, nearest_node}};
    for (const auto& row : words)
      all.push_back({row.name, word, {}, [&row](const SceneTable&) { return choice_of(row); }});
    const auto more = selector_combinations();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return kinds;
}

}  // namespace phynness::scene_detail

namespace phynness {

Selection free_surface() {
  return {{std::make_shared<const NodeChoice>(scene_detail::choice_of(scene_detail::free_surface_row)), false, {}}};
}

}  // namespace phynness
