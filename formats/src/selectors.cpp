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

template <class Inside>
NodeList where(const SelectableBody& body, const NodeList& candidates, Inside inside) {
  NodeList nodes;
  for (const std::int32_t i : candidates)
    if (inside(Vector(body.mesh.nodes.row(i)))) nodes.push_back(i);
  return nodes;
}

NodeList without_fixed(const SelectableBody& body, const NodeList& nodes) {
  NodeList free;
  std::set_difference(nodes.begin(), nodes.end(), body.fixed.begin(), body.fixed.end(), std::back_inserter(free));
  return free;
}

/// A selector of what lies in a part of space.
struct Region : NodeChoice {
  /// How far each point lies outside [m]; 0 inside.
  using Distance = std::function<double(const Vector&)>;
  virtual Distance outside_m(const SelectableBody& body) const = 0;
  virtual bool in_fractions() const = 0;

  NodeList pick(const SelectableBody& body, const PickRequest& request) const final {
    const Distance outside = outside_m(body);
    return where(body, request.candidates, [&](const Vector& x) { return outside(x) <= body.slack_m; });
  }
  std::string remedy_if_empty(const SelectableBody& body, const PickRequest& request) const final {
    const Distance outside = outside_m(body);
    double best = std::numeric_limits<double>::infinity();
    std::int32_t nearest = -1;
    for (const std::int32_t i : body.surface)
      if (const double d = outside(body.mesh.nodes.row(i)); d < best) best = d, nearest = i;
    if (nearest < 0) return NodeChoice::remedy_if_empty(body, request);
    const Vector x = body.mesh.nodes.row(nearest), low = to_row(body.low), size = to_row(body.high) - low;
    Vec3 shown{x(0), x(1), x(2)};
    if (in_fractions())
      for (int k = 0; k < 3; ++k) shown[k] = size(k) > 0 ? (x(k) - low(k)) / size(k) : 0;
    return "the nearest node of the surface is " + std::to_string(nearest) + " at " + shown_text(shown) +
           units(in_fractions()) + ", " + length_text(best) + " outside of it: move or widen it so far";
  }
};

struct Box final : Region {
  Place low, high;

  explicit Box(const SceneTable& table) {
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
    low = {*a, relative}, high = {*b, relative};
  }
  std::string text() const override { return "box { min" + low.text() + ", max" + high.text() + " }"; }
  std::string description() const override {
    return "box " + shown_text(low.x) + " to " + shown_text(high.x) + low.units();
  }
  Distance outside_m(const SelectableBody& body) const override {
    return
        [a = low.in(body), b = high.in(body)](const Vector& x) { return (a - x).cwiseMax(x - b).cwiseMax(0).norm(); };
  }
  bool in_fractions() const override { return low.fraction; }
};

struct Sphere final : Region {
  Place center;
  double radius_m = 0;

  explicit Sphere(const SceneTable& table) : center(parse_place(table, "center")) {
    const auto radius = table.number("radius_m", length);
    if (!radius) table.missing("radius_m", "", "add radius_m in metres");
    radius_m = *radius;
  }
  std::string text() const override {
    return "sphere { center" + center.text() + ", radius_m = " + shortest(radius_m) + " }";
  }
  std::string description() const override {
    return "sphere at " + shown_text(center.x) + center.units() + ", radius " + length_text(radius_m);
  }
  Distance outside_m(const SelectableBody& body) const override {
    return [c = center.in(body), r = radius_m](const Vector& x) { return std::max((x - c).norm() - r, 0.0); };
  }
  bool in_fractions() const override { return center.fraction; }
};

struct Plane final : Region {
  Place point;
  Vec3 normal;
  double tolerance_m;

  explicit Plane(const SceneTable& table) : point(parse_place(table, "point")), normal(parse_normal(table)) {
    constexpr double default_tolerance_m = 1e-6;
    tolerance_m = table.number_or("tolerance_m", default_tolerance_m, length);
  }
  std::string text() const override {
    return "plane { point" + point.text() + ", normal = " + exact_text(normal) +
           ", tolerance_m = " + shortest(tolerance_m) + " }";
  }
  std::string description() const override {
    return "plane through " + shown_text(point.x) + point.units() + ", normal " + shown_text(normal) + ", tolerance " +
           length_text(tolerance_m);
  }
  Distance outside_m(const SelectableBody& body) const override {
    return [p = point.in(body), n = Vector(to_row(normal).normalized()), t = tolerance_m](const Vector& x) {
      return std::max(std::abs((x - p).dot(n)) - t, 0.0);
    };
  }
  bool in_fractions() const override { return point.fraction; }
};

struct HalfSpace final : Region {
  Place point;
  Vec3 normal;

  explicit HalfSpace(const SceneTable& table) : point(parse_place(table, "point")), normal(parse_normal(table)) {}
  std::string text() const override {
    return "half_space { point" + point.text() + ", normal = " + exact_text(normal) + " }";
  }
  std::string description() const override {
    return "half space below " + shown_text(point.x) + point.units() + ", normal " + shown_text(normal);
  }
  Distance outside_m(const SelectableBody& body) const override {
    return [p = point.in(body), n = Vector(to_row(normal).normalized())](const Vector& x) {
      return std::max((x - p).dot(n), 0.0);
    };
  }
  bool in_fractions() const override { return point.fraction; }
};

struct Group final : NodeChoice {
  std::string group;

  explicit Group(const SceneTable& table) : group(*table.text("group")) {
    if (group.empty()) table.reject("group", "is empty", "give the name of a physical group of the mesh file");
  }
  std::string text() const override { return "group \"" + group + "\""; }
  std::string description() const override { return "group '" + group + "'"; }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    const auto& groups = body.mesh.groups;
    if (const auto found = groups.find(group); found != groups.end()) return found->second;
    std::string names;
    for (const auto& [known, nodes] : groups) names += (names.empty() ? "'" : ", '") + known + "'";
    throw input_error(request.place + "the mesh has no physical group for the " + request.nodes, group,
                      names.empty() ? "the mesh has no groups: select by box, sphere or plane"
                                    : "use one of the groups of the mesh: " + names);
  }
};

struct Numbers final : NodeChoice {
  NodeList nodes;

  explicit Numbers(const SceneTable& table) {
    const auto* list = table.find("nodes")->as_array();
    if (!list) table.reject("nodes", "must be an array of node numbers", "write nodes = [0, 5, 7]");
    if (list->empty()) table.reject("nodes", "is an empty list", "give at least one node, or remove the selector");
    for (const auto& item : *list) {
      const auto* number = item.as_integer();
      if (!number || number->get() < 0 || number->get() > std::numeric_limits<std::int32_t>::max())
        refuse(table.where(item), table.label("nodes") + " must contain integers of at least 0", shown(item),
               "give node numbers, which start with 0, in the order of the mesh file");
      nodes.push_back(static_cast<std::int32_t>(number->get()));
    }
  }
  std::string text() const override {
    std::string list;
    for (const std::int32_t node : nodes) list += (list.empty() ? "" : ", ") + std::to_string(node);
    return "nodes [" + list + "]";
  }
  std::string description() const override { return "a list of " + std::to_string(nodes.size()) + " nodes"; }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    for (const std::int32_t node : nodes)
      if (node >= body.mesh.n_nodes())
        throw input_error(request.place + "a node number of the " + request.nodes + " is out of range",
                          std::to_string(node), "give numbers from 0 to " + std::to_string(body.mesh.n_nodes() - 1));
    return nodes;
  }
};

struct Nearest final : NodeChoice {
  Place point;

  explicit Nearest(const SceneTable& table) : point(parse_place(table, "point")) {}
  std::string text() const override { return "nearest { point" + point.text() + " }"; }
  std::string description() const override { return "node nearest to " + shown_text(point.x) + point.units(); }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    const Vector x = point.in(body);
    double best = std::numeric_limits<double>::infinity();
    NodeList nearest;
    for (const std::int32_t i : request.candidates)
      if (const double d = (Vector(body.mesh.nodes.row(i)) - x).squaredNorm(); d < best) best = d, nearest = {i};
    return nearest;
  }
};

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

struct Word final : NodeChoice {
  const WordRow& row;
  explicit Word(const WordRow& of) : row(of) {}
  std::string text() const override { return row.name; }
  std::string description() const override { return '"' + text() + '"'; }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    return row.pick(body, request);
  }
  bool needs_fixed() const override { return row.needs_fixed; }
  bool selects_all() const override { return row.selects_all; }
};

}  // namespace

const std::vector<SelectorKind>& selector_kinds() {
  static const std::vector<SelectorKind> kinds = [] {
    std::vector<SelectorKind> all = {row<Box>("box", {"min_m", "max_m", "min_fraction", "max_fraction"}),
                                     row<Sphere>("sphere", {"center_m", "center_fraction", "radius_m"}),
                                     row<Plane>("plane", {"point_m", "point_fraction", "normal", "tolerance_m"}),
                                     row<HalfSpace>("half_space", {"point_m", "point_fraction", "normal"}),
                                     row<Group>("group"),
                                     row<Numbers>("nodes"),
                                     row<Nearest>("nearest", {"point_m", "point_fraction"})};
    for (const auto& word : words)
      all.push_back({word.name, SelectorForm::word, {}, [&word](const SceneTable&) {
                       return std::make_shared<const Word>(word);
                     }});
    const auto more = selector_combinations();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return kinds;
}

}  // namespace phynness::scene_detail

namespace phynness {

Selection free_surface() {
  return {{std::make_shared<const scene_detail::Word>(scene_detail::free_surface_row), false, {}}};
}

}  // namespace phynness
