// Selectors that combine other selections: intersection, difference, complement, and nodes near a selection. Each of
// the combined selections has its usual meaning and must select a node.
#include <algorithm>
#include <phynness/formats/mesh.hpp>

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

}  // namespace

std::vector<SelectorKind> selector_combinations() {
  std::vector<SelectorKind> kinds;
  for (const auto& kind : combinations)
    kinds.push_back({kind.name, SelectorForm::value, {}, [&kind](const SceneTable& table) {
                       return std::make_shared<const OfSeveral>(table, kind);
                     }});
  kinds.push_back(row<Not>("not"));
  kinds.push_back(row<Near>("near", {"to", "distance_m"}));
  return kinds;
}

}  // namespace phynness::scene_detail
