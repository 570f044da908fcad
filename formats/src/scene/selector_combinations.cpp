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
  return std::any_of(selection.begin(), selection.end(), [](const Selector& s) { return s.choice->needs_fixed; });
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

std::string joined(const std::vector<Selection>& parts, std::string (*of)(const Selection&), const char* begin,
                   const char* between, const char* end) {
  std::string all;
  for (const auto& part : parts) all.append(all.empty() ? begin : between).append(of(part));
  return all + end;
}

/// A selector whose value is an array of selections.
NodeChoice of_several(const SceneTable& table, const Combination& kind) {
  const std::string name = kind.name;
  const auto* list = table.find(name)->as_array();
  if (!list || list->size() < 2)
    table.reject(name, "must be an array of at least two selections",
                 "write for example " + name + " = [{ sphere = { ... } }, \"free-surface\"]");
  std::vector<Selection> parts;
  for (const auto& item : *list) parts.push_back(parse_selection(item, table, name));
  NodeChoice choice{name + joined(parts, selection_text, " { ", ", ", " }"),
                    name + joined(parts, selection_description, " of [", "] and [", "]")};
  choice.needs_fixed = std::any_of(parts.begin(), parts.end(), any_needs_fixed);
  choice.spreads = std::any_of(parts.begin(), parts.end(), phynness::spreads);
  choice.pick = [parts, &kind](const SelectableBody& body, const PickRequest& request) {
    NodeList nodes = union_of(parts.front(), body, request);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      NodeList rest;
      kind.combine(nodes, union_of(parts[i], body, request), rest);
      nodes = std::move(rest);
    }
    return nodes;
  };
  choice.remedy_if_empty = [parts, &kind](const SelectableBody& body, const PickRequest& request) {
    std::string all;
    for (const auto& part : parts)
      all.append(all.empty() ? "" : ", ").append(counted_nodes(part, union_of(part, body, request).size()));
    return kind.nothing + all + kind.remedy;
  };
  return choice;
}

NodeChoice all_but(const SceneTable& table) {
  const Selection selection = parse_selection(*table.find("not"), table, "not");
  return {"not { " + selection_text(selection) + " }", "not [" + selection_description(selection) + "]",
          [selection](const SelectableBody& body, const PickRequest& request) {
            const NodeList nodes = union_of(selection, body, request);
            NodeList others;
            std::set_difference(request.candidates.begin(), request.candidates.end(), nodes.begin(), nodes.end(),
                                std::back_inserter(others));
            return others;
          },
          [](const SelectableBody&, const PickRequest&) { return "every node is in what it excludes: exclude less"; },
          any_needs_fixed(selection)};
}

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

NodeChoice near_to(const SceneTable& table) {
  if (!table.has("to")) table.missing("to", "", "add a selection, such as to = \"fixed\"");
  const Selection selection = parse_selection(*table.find("to"), table, "to");
  const auto distance_m = table.number("distance_m", length);
  if (!distance_m) table.missing("distance_m", "", "add distance_m in metres");
  NodeChoice choice{"near { to = " + selection_text(selection) + ", distance_m = " + shortest(*distance_m) + " }",
                    "within " + length_text(*distance_m) + " of [" + selection_description(selection) + "]",
                    [=](const SelectableBody& body, const PickRequest& request) {
                      return near_nodes(body.mesh.nodes, request.candidates, union_of(selection, body, request),
                                        *distance_m + body.slack_m);
                    }};
  choice.needs_fixed = any_needs_fixed(selection);
  return choice;
}

constexpr const char* spread_names[] = {"spacing_m", "spacing", "count"};

/// Nodes that are spread evenly over a part of the surface, at given distances, at those that the tool needs, or a
/// given number of them.
struct Spread {
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
  NodeList pick(const SelectableBody& body, const PickRequest& request) const {
    const NodeList nodes = candidates(body, request);
    if (count > nodes.size() && !nodes.empty())
      throw input_error(
          request.place + "count is larger than the number of nodes that it chooses from",
          std::to_string(count) + " of " + std::to_string(nodes.size()),
          "give at most " + std::to_string(nodes.size()) + ", a finer mesh, or a larger part in `within`");
    const double spacing = spacing_of(body, request);
    NodeList kept;
    std::ranges::set_intersection(body.probed, nodes, std::back_inserter(kept));
    const bool enough = count > 0 && kept.size() > count;
    NodeList chosen = spread_nodes(body.mesh.nodes, body.mesh.surface, enough ? kept : nodes, spacing, count,
                                   enough ? NodeList() : kept);
    if (count == 0 && chosen.size() < 3 && nodes.size() > chosen.size())
      throw input_error(request.place + "the spacing is too large for the part of the surface that it is for",
                        length_text(spacing) + ", of " + std::to_string(nodes.size()) + " nodes " +
                            std::to_string(chosen.size()) + " chosen",
                        "give a smaller spacing, such as " + length_text(spacing / 4) +
                            ", or count = " + std::to_string(chosen.size()) + " if so few points are meant");
    return chosen;
  }
  NodeList candidates(const SelectableBody& body, const PickRequest& request) const {
    const NodeList nodes = union_of(within, body, request);
    NodeList on_surface, far;
    std::set_intersection(nodes.begin(), nodes.end(), body.surface.begin(), body.surface.end(),
                          std::back_inserter(on_surface));
    if (!(from_fixed_m > 0)) return on_surface;
    const NodeList near = near_nodes(body.mesh.nodes, on_surface, body.fixed, from_fixed_m - body.slack_m);
    std::set_difference(on_surface.begin(), on_surface.end(), near.begin(), near.end(), std::back_inserter(far));
    return far;
  }
  std::string warning(const SelectableBody& body, const NodeList& picked) const {
    const NodeList nodes = candidates(body, {body.surface, "active nodes", ""});
    if (!spacing_m || !std::includes(picked.begin(), picked.end(), nodes.begin(), nodes.end())) return {};
    return "spacing_m = " + shortest(*spacing_m) + " is below the edges of the mesh, so that each of the " +
           std::to_string(nodes.size()) + " nodes is probed; give a larger spacing, or spacing = \"auto\"";
  }
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

NodeChoice spread_over(const SceneTable& table) {
  const Spread spread(table);
  const bool apart = spread.from_fixed_m > 0;
  NodeChoice choice{"spread { " + spread.size() + ", within = " + selection_text(spread.within) +
                        (apart ? ", from_fixed_m = " + shortest(spread.from_fixed_m) : "") + " }",
                    "points with " + spread.size() + " on [" + selection_description(spread.within) + "]",
                    std::bind_front(&Spread::pick, spread)};
  choice.needs_fixed = apart || any_needs_fixed(spread.within);
  choice.spreads = true;
  choice.warning = std::bind_front(&Spread::warning, spread);
  choice.remedy_if_empty = [apart](const SelectableBody&, const PickRequest&) {
    return apart ? "make from_fixed_m smaller, or `within` larger" : "give a part of the surface in `within`";
  };
  return choice;
}

}  // namespace

std::vector<SelectorKind> selector_combinations() {
  std::vector<SelectorKind> kinds;
  for (const auto& kind : combinations)
    kinds.push_back(
        {kind.name, SelectorForm::value, {}, [&kind](const SceneTable& table) { return of_several(table, kind); }});
  kinds.push_back({"not", SelectorForm::value, {}, all_but});
  kinds.push_back({"near", SelectorForm::table, {"to", "distance_m"}, near_to});
  for (const char* name : spread_names)
    kinds.push_back({name, SelectorForm::value, {"within", "from_fixed_m"}, spread_over});
  return kinds;
}

}  // namespace phynness::scene_detail
