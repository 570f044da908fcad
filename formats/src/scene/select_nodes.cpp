// Nodes of a selection: the union of the nodes of its selectors.
#include <algorithm>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>

#include "selectors.hpp"

namespace phynness {
namespace {

// Relative to the diagonal of the bounding box: a node on the face of a box, up to rounding, is in the box.
constexpr double on_the_border = 1e-9;

NodeList picked(const Selector& selector, const SelectableBody& body, const PickRequest& request) {
  NodeList nodes = selector.choice->pick(body, request);
  sort_unique(nodes);
  if (!selector.surface_only) return nodes;
  NodeList on_surface;
  std::set_intersection(nodes.begin(), nodes.end(), body.surface.begin(), body.surface.end(),
                        std::back_inserter(on_surface));
  return on_surface;
}

std::string description(const Selector& selector) {
  return selector.choice->description + (selector.surface_only ? ", surface nodes only" : "");
}

NodeList all_nodes(const SelectableBody& body) {
  NodeList every_node(static_cast<std::size_t>(body.mesh.n_nodes()));
  std::iota(every_node.begin(), every_node.end(), 0);
  return every_node;
}

std::string remedy_if_empty(const Selector& selector, const SelectableBody& body, const PickRequest& request) {
  const NodeList every_node = all_nodes(body);
  const auto inside = selector.choice->pick(body, {every_node, request.nodes, request.place}).size();
  if (inside == 0) return selector.choice->remedy_if_empty(body, request);
  return "remove surface_only for the " + std::to_string(inside) +
         " nodes that it selects inside the body; otherwise " + selector.choice->remedy_if_empty(body, request);
}

}  // namespace

SelectableBody::SelectableBody(const Mesh& of) : mesh(of), surface(surface_nodes(of.surface)) {
  const Eigen::RowVector3d least = of.nodes.colwise().minCoeff(), most = of.nodes.colwise().maxCoeff();
  low = {least(0), least(1), least(2)};
  high = {most(0), most(1), most(2)};
  slack_m = on_the_border * (most - least).norm();
}

bool spreads(const Selection& selection) {
  return std::any_of(selection.begin(), selection.end(), [](const Selector& s) { return s.choice->spreads; });
}

namespace scene_detail {

std::string selection_text(const Selection& selection) {
  std::string result;
  for (const auto& s : selection)
    result += (result.empty() ? "" : " + ") + s.choice->text + (s.surface_only ? " surface_only" : "");
  return result;
}

std::string selection_description(const Selection& selection) {
  std::string result;
  for (const auto& s : selection) result += (result.empty() ? "" : " or ") + description(s);
  return result;
}

NodeList union_of(const Selection& selection, const SelectableBody& body, const PickRequest& request) {
  const NodeList every_node = all_nodes(body);
  NodeList nodes;
  for (const Selector& selector : selection) {
    const PickRequest own{selector.surface_only ? body.surface : every_node, request.nodes,
                          selector.where.file.empty() ? request.place : selector.where.prefix()};
    const NodeList more = picked(selector, body, own);
    if (more.empty())
      throw input_error(own.place + "a selector of the " + own.nodes + " selects no node", description(selector),
                        remedy_if_empty(selector, body, own) + "; the mesh reaches from " + shown_text(body.low) +
                            " to " + shown_text(body.high) + " m");
    nodes.insert(nodes.end(), more.begin(), more.end());
  }
  sort_unique(nodes);
  return nodes;
}

}  // namespace scene_detail

NodeList select_nodes(const Selection& selection, const SelectableBody& body, const char* what,
                      const SourceLocation& where) {
  const std::string what_nodes = std::string(what) + " nodes";
  if (selection.empty())
    throw input_error(where.prefix() + "there are no " + what_nodes, "the selection is empty",
                      std::string("add a selector to ") + what);
  return scene_detail::union_of(selection, body, {all_nodes(body), what_nodes, where.prefix()});
}

}  // namespace phynness
