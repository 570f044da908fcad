// Selectors that combine other selections: intersection, difference, complement, nodes near a selection, and nodes
// spread over one. Each of the combined selections has its usual meaning and must select a node.
#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/probe_points.hpp>

#include "scene_sections.hpp"
#include "selectors.hpp"

namespace phynness::scene_detail {
namespace {

bool any_needs_fixed(const Selection& selection) {
  return std::any_of(selection.begin(), selection.end(), [](const Selector& s) { return s.choice->needs_fixed(); });
}

std::string counted_nodes(const Selection& selection, std::size_t n) {
  return selection_description(selection) + " (" + std::to_string(n) + (n == 1 ? " node)" : " nodes)");
}

/// A combination of two ascending lists of nodes; several are combined from the first on.
struct Combination {
  const char* name;
  void (*combine)(const NodeList& a, const NodeList& b, NodeList& out);
  const char *nothing, *remedy;  ///< around the list of the selections, if no node is left
};
constexpr Combination combinations[] = {
    {"intersection",
     [](const NodeList& a, const NodeList& b, NodeList& out) {
       std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
     },
     "no node is in all of ", ": move or widen them until they overlap"},
    {"difference",
     [](const NodeList& a, const NodeList& b, NodeList& out) {
       std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
     },
     "nothing is left of the first of ", ": widen the first or narrow the others"}};

/// A selector whose value is an array of selections.
struct OfSeveral final : NodeChoice {
  const Combination& kind;
  std::vector<Selection> parts;

  OfSeveral(const SceneTable& table, const Combination& of) : kind(of) {
    const std::string name = of.name;
    const auto* list = table.find(name)->as_array();
    if (!list || list->size() < 2)
      table.reject(name, "must be an array of at least two selections",
                   "write for example " + name + " = [{ sphere = { ... } }, \"free-surface\"]");
    for (const auto& item : *list) parts.push_back(parse_selection(item, table, name));
  }
  std::string text() const override { return joined(selection_text, " { ", ", ", " }"); }
  std::string description() const override { return joined(selection_description, " of [", "] and [", "]"); }
  bool needs_fixed() const override { return std::any_of(parts.begin(), parts.end(), any_needs_fixed); }
  bool spreads() const override { return std::any_of(parts.begin(), parts.end(), phynness::spreads); }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    NodeList nodes = union_of(parts.front(), body, request);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      NodeList rest;
      kind.combine(nodes, union_of(parts[i], body, request), rest);
      nodes = std::move(rest);
    }
    return nodes;
  }
  std::string remedy_if_empty(const SelectableBody& body, const PickRequest& request) const override {
    std::string all;
    for (const auto& part : parts)
      all.append(all.empty() ? "" : ", ").append(counted_nodes(part, union_of(part, body, request).size()));
    return kind.nothing + all + kind.remedy;
  }

 private:
  std::string joined(std::string (*of)(const Selection&), const char* begin, const char* between,
                     const char* end) const {
    std::string all;
    for (const auto& part : parts) all.append(all.empty() ? begin : between).append(of(part));
    return kind.name + all + end;
  }
};

struct Not final : NodeChoice {
  Selection selection;

  explicit Not(const SceneTable& table) : selection(parse_selection(*table.find("not"), table, "not")) {}
  std::string text() const override { return "not { " + selection_text(selection) + " }"; }
  std::string description() const override { return "not [" + selection_description(selection) + "]"; }
  bool needs_fixed() const override { return any_needs_fixed(selection); }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    const NodeList nodes = union_of(selection, body, request);
    NodeList others;
    std::set_difference(request.candidates.begin(), request.candidates.end(), nodes.begin(), nodes.end(),
                        std::back_inserter(others));
    return others;
  }
  std::string remedy_if_empty(const SelectableBody&, const PickRequest&) const override {
    return "every node is in what it excludes: exclude less";
  }
};

/// The `candidates`, in their order, within `distance` of one of `targets`.
NodeList near_nodes(const Points& nodes, const NodeList& candidates, NodeList targets, double distance) {
  std::sort(targets.begin(), targets.end(), [&](auto a, auto b) { return nodes(a, 0) < nodes(b, 0); });
  NodeList near;
  for (const std::int32_t i : candidates) {
    // Only targets with an x within the distance can be near.
    auto t = std::lower_bound(targets.begin(), targets.end(), nodes(i, 0),
                              [&](std::int32_t target, double x) { return x - nodes(target, 0) > distance; });
    while (t != targets.end() && nodes(*t, 0) - nodes(i, 0) <= distance &&
           (nodes.row(*t) - nodes.row(i)).norm() > distance)
      ++t;
    if (t != targets.end() && nodes(*t, 0) - nodes(i, 0) <= distance) near.push_back(i);
  }
  return near;
}

struct Near final : NodeChoice {
  Selection selection;
  double distance_m = 0;

  explicit Near(const SceneTable& table) {
    if (!table.has("to")) table.missing("to", "", "add a selection, such as to = \"fixed\"");
    selection = parse_selection(*table.find("to"), table, "to");
    const auto given = table.number("distance_m", length);
    if (!given) table.missing("distance_m", "", "add distance_m in metres");
    distance_m = *given;
  }
  std::string text() const override {
    return "near { to = " + selection_text(selection) + ", distance_m = " + shortest(distance_m) + " }";
  }
  std::string description() const override {
    return "within " + length_text(distance_m) + " of [" + selection_description(selection) + "]";
  }
  bool needs_fixed() const override { return any_needs_fixed(selection); }
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    return near_nodes(body.mesh.nodes, request.candidates, union_of(selection, body, request),
                      distance_m + body.slack_m);
  }
};

constexpr const char* spread_names[] = {"spacing_m", "spacing", "count"};

/// Nodes that are spread evenly over a part of the surface, at given distances, at those that the tool needs, or a
/// given number of them.
struct Spread final : NodeChoice {
  std::optional<double> spacing_m;  ///< absent: `count`, or as the tool needs
  std::size_t count = 0;
  Selection within = free_surface();
  double from_fixed_m = 0;

  explicit Spread(const SceneTable& table) : spacing_m(table.number("spacing_m", length)) {
    if (const auto number = table.integer("count", 1, std::numeric_limits<std::int32_t>::max()))
      count = static_cast<std::size_t>(*number);
    if (table.has("spacing")) table.choice("spacing", Words<int>{{"auto", 0}});
    if (table.has("within")) within = parse_selection(*table.find("within"), table, "within");
    if (const auto given = table.number("from_fixed_m", length)) from_fixed_m = *given;
  }
  std::string text() const override {
    return "spread { " + size() + ", within = " + selection_text(within) +
           (from_fixed_m > 0 ? ", from_fixed_m = " + shortest(from_fixed_m) : "") + " }";
  }
  std::string description() const override {
    return "points with " + size() + " on [" + selection_description(within) + "]";
  }
  bool needs_fixed() const override { return from_fixed_m > 0 || any_needs_fixed(within); }
  bool spreads() const override { return true; }

  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    const NodeList nodes = candidates(body, request);
    for (const auto i : nodes)
      if (!body.image.empty() &&
          !std::binary_search(nodes.begin(), nodes.end(), body.image[static_cast<std::size_t>(i)]))
        throw input_error(request.place + "`within` is not symmetric, as [mesh] symmetry wants the active nodes",
                          "node " + std::to_string(i) + " is in it, and its mirror image is not",
                          "select both sides of the plane, or remove [mesh] symmetry");
    if (count > nodes.size() && !nodes.empty())
      throw input_error(
          request.place + "count is larger than the number of nodes that it chooses from",
          std::to_string(count) + " of " + std::to_string(nodes.size()),
          "give at most " + std::to_string(nodes.size()) + ", a finer mesh, or a larger part in `within`");
    const double spacing = spacing_of(body, request);
    NodeList chosen = spread_nodes(body.mesh.nodes, body.mesh.surface, nodes, spacing, count, body.image);
    if (count > chosen.size() && !nodes.empty())
      throw input_error(request.place + "an odd count is not symmetric, because no node is on the plane of symmetry",
                        std::to_string(count), "give " + std::to_string(count + 1));
    if (count == 0 && chosen.size() < 3 && nodes.size() > chosen.size())
      throw input_error(request.place + "the spacing is too large for the part of the surface that it is for",
                        length_text(spacing) + ", of " + std::to_string(nodes.size()) + " nodes " +
                            std::to_string(chosen.size()) + " chosen",
                        "give a smaller spacing, such as " + length_text(spacing / 4) +
                            ", or count = " + std::to_string(chosen.size()) + " if so few points are meant");
    return chosen;
  }
  NodeList candidates(const SelectableBody& body, const PickRequest& request) const override {
    const NodeList nodes = union_of(within, body, request);
    NodeList on_surface, far;
    std::set_intersection(nodes.begin(), nodes.end(), body.surface.begin(), body.surface.end(),
                          std::back_inserter(on_surface));
    if (!(from_fixed_m > 0)) return on_surface;
    const NodeList near = near_nodes(body.mesh.nodes, on_surface, body.fixed, from_fixed_m - body.slack_m);
    std::set_difference(on_surface.begin(), on_surface.end(), near.begin(), near.end(), std::back_inserter(far));
    return far;
  }
  std::string remedy_if_empty(const SelectableBody&, const PickRequest&) const override {
    return from_fixed_m > 0 ? "make from_fixed_m smaller, or `within` larger"
                            : "give a part of the surface in `within`";
  }
  std::string warning(const SelectableBody& body, const NodeList& picked) const override {
    const NodeList nodes = candidates(body, {body.surface, "active nodes", ""});
    if (!spacing_m || !std::includes(picked.begin(), picked.end(), nodes.begin(), nodes.end())) return {};
    return "spacing_m = " + shortest(*spacing_m) + " is below the edges of the mesh, so that each of the " +
           std::to_string(nodes.size()) + " nodes is probed; give a larger spacing, or spacing = \"auto\"";
  }

 private:
  std::string size() const {
    return spacing_m   ? "spacing_m = " + shortest(*spacing_m)
           : count > 0 ? "count = " + std::to_string(count)
                       : "spacing = auto";
  }
  double spacing_of(const SelectableBody& body, const PickRequest& request) const {
    if (spacing_m || count > 0) return spacing_m.value_or(0);
    if (!(body.tool_radius_m > 0))
      throw input_error(request.place + "spacing = \"auto\" needs a round tool, whose radius it follows",
                        "[probe] kind = \"node\"",
                        "give spacing_m or count, or [probe] kind = \"patch\" with tool_radius_m");
    return auto_spacing_of_radius * body.tool_radius_m;
  }
};

}  // namespace

std::vector<SelectorKind> selector_combinations() {
  std::vector<SelectorKind> kinds;
  for (const auto& kind : combinations)
    kinds.push_back({kind.name, SelectorForm::value, {}, [&kind](const SceneTable& table) {
                       return std::make_shared<const OfSeveral>(table, kind);
                     }});
  kinds.push_back(row<Not>("not"));
  kinds.push_back(row<Near>("near", {"to", "distance_m"}));
  for (const char* name : spread_names) {
    kinds.push_back(row<Spread>(name));
    kinds.back().keys = {"within", "from_fixed_m"};
  }
  return kinds;
}

}  // namespace phynness::scene_detail
