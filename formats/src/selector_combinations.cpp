// Selectors that are made of other selections: what they have in common, what is in one and not in the others, what is
// not in one, what is near one. Each of these selections means what it means alone and must select a node.
#include <algorithm>
#include <phynness/formats/mesh.hpp>

#include "near_nodes.hpp"
#include "scene_sections.hpp"
#include "selectors.hpp"

namespace phynness::scene_detail {
namespace {

using CombinedKeys = std::vector<std::string_view>;

bool any_needs_fixed(const Selection& selection) {
  return std::any_of(selection.begin(), selection.end(), [](const Selector& s) { return s.choice->needs_fixed(); });
}

std::string counted_nodes(const Selection& selection, std::size_t n) {
  return selection_description(selection) + " (" + std::to_string(n) + (n == 1 ? " node)" : " nodes)");
}

/// A selector whose value is an array of selections.
struct OfSeveral : NodeChoice {
  static constexpr SelectorForm form = SelectorForm::value;
  static CombinedKeys keys() { return {}; }
  std::vector<Selection> parts;
  std::string_view own_name;

  OfSeveral(const SceneTable& table, std::string_view name) : own_name(name) {
    const auto* list = table.find(name)->as_array();
    if (!list || list->size() < 2)
      table.reject(name, "must be an array of at least two selections",
                   "write for example " + std::string(name) + " = [{ sphere = { ... } }, \"free-surface\"]");
    for (const auto& item : *list) parts.push_back(parse_selection(item, table, name));
  }
  std::string text() const final { return joined(selection_text, " { ", ", ", " }"); }
  std::string description() const final { return joined(selection_description, " of [", "] and [", "]"); }
  bool needs_fixed() const final { return std::any_of(parts.begin(), parts.end(), any_needs_fixed); }

 protected:
  std::string joined(std::string (*of)(const Selection&), const char* begin, const char* between,
                     const char* end) const {
    std::string all;
    for (const auto& part : parts) all.append(all.empty() ? begin : between).append(of(part));
    return std::string(own_name) + all + end;
  }
  /// Each part with its number of nodes, for messages.
  std::string with_counts(const SelectableBody& body, const PickRequest& request) const {
    std::string all;
    for (const auto& part : parts)
      all.append(all.empty() ? "" : ", ").append(counted_nodes(part, union_of(part, body, request).size()));
    return all;
  }
};

struct Intersection final : OfSeveral {
  static constexpr std::string_view name = "intersection";
  explicit Intersection(const SceneTable& table) : OfSeveral(table, name) {}
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    NodeList nodes = union_of(parts.front(), body, request);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const NodeList other = union_of(parts[i], body, request);
      NodeList both;
      std::set_intersection(nodes.begin(), nodes.end(), other.begin(), other.end(), std::back_inserter(both));
      nodes = std::move(both);
    }
    return nodes;
  }
  std::string remedy_if_empty(const SelectableBody& body, const PickRequest& request) const override {
    return "no node is in all of " + with_counts(body, request) + ": move or widen them until they overlap";
  }
};

struct Difference final : OfSeveral {
  static constexpr std::string_view name = "difference";
  explicit Difference(const SceneTable& table) : OfSeveral(table, name) {}
  NodeList pick(const SelectableBody& body, const PickRequest& request) const override {
    NodeList nodes = union_of(parts.front(), body, request);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const NodeList other = union_of(parts[i], body, request);
      NodeList rest;
      std::set_difference(nodes.begin(), nodes.end(), other.begin(), other.end(), std::back_inserter(rest));
      nodes = std::move(rest);
    }
    return nodes;
  }
  std::string remedy_if_empty(const SelectableBody& body, const PickRequest& request) const override {
    return "nothing is left of the first of " + with_counts(body, request) + ": widen the first or narrow the others";
  }
};

struct Not final : NodeChoice {
  static constexpr std::string_view name = "not";
  static constexpr SelectorForm form = SelectorForm::value;
  static CombinedKeys keys() { return {}; }
  Selection selection;

  explicit Not(const SceneTable& table) : selection(parse_selection(*table.find(name), table, name)) {}
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

struct Near final : NodeChoice {
  static constexpr std::string_view name = "near";
  static constexpr SelectorForm form = SelectorForm::table;
  static CombinedKeys keys() { return {"to", "distance_m"}; }
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
  return {row<Intersection>(), row<Difference>(), row<Not>(), row<Near>()};
}

}  // namespace phynness::scene_detail
