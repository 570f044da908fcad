// Nodes of a selection: the union of the nodes of its selectors.
#include <algorithm>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/selector.hpp>

#include "scene_table.hpp"

namespace phynness {
namespace {

using scene_detail::shown_text;

// Relative to the diagonal of the bounding box: a node on the face of a box, up to rounding, is in the box.
constexpr double on_the_border = 1e-9;

std::string at(const SourceLocation& where) { return where.file.empty() ? "" : where.str() + ": "; }

void sort_unique(NodeList& nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

NodeList picked(const Selector& selector, const SelectableBody& body, const PickRequest& request) {
  NodeList nodes = selector.choice->pick(body, request);
  sort_unique(nodes);
  if (!selector.surface_only) return nodes;
  NodeList on_surface;
  std::set_intersection(nodes.begin(), nodes.end(), body.surface.begin(), body.surface.end(),
                        std::back_inserter(on_surface));
  return on_surface;
}

}  // namespace

SelectableBody::SelectableBody(const Mesh& of) : mesh(of), surface(surface_nodes(of.surface)) {
  const Eigen::RowVector3d least = of.nodes.colwise().minCoeff(), most = of.nodes.colwise().maxCoeff();
  low = {least(0), least(1), least(2)};
  high = {most(0), most(1), most(2)};
  slack_m = on_the_border * (most - least).norm();
}

NodeList select_nodes(const Selection& selection, const SelectableBody& body, const char* what,
                      const SourceLocation& where) {
  NodeList every_node(static_cast<std::size_t>(body.mesh.n_nodes())), nodes;
  std::iota(every_node.begin(), every_node.end(), 0);
  const std::string what_nodes = std::string(what) + " nodes";
  for (const Selector& selector : selection) {
    const std::string place = at(selector.where.file.empty() ? where : selector.where);
    const NodeList more =
        picked(selector, body, {selector.surface_only ? body.surface : every_node, what_nodes, place});
    if (more.empty())
      throw input_error(
          place + "a selector of the " + what_nodes + " selects no node",
          selector.choice->description() + (selector.surface_only ? ", surface nodes only" : ""),
          "the mesh reaches from " + shown_text(body.low) + " to " + shown_text(body.high) + " m: widen the selector");
    nodes.insert(nodes.end(), more.begin(), more.end());
  }
  if (nodes.empty())
    throw input_error(at(where) + "there are no " + what_nodes, "the selection is empty",
                      std::string("add a selector to ") + what);
  sort_unique(nodes);
  return nodes;
}

}  // namespace phynness
