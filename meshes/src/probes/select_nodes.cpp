// Nodes of a selection, or points in cells: the union of those of its selectors.
#include "probes/select_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/meshes/probe_points.hpp>

#include "surface/geometry.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;
using enum SelectorKind;

// Relative to the diagonal of the bounding box: a node on the face of a box, up to rounding, is in the box.
constexpr double on_the_border = 1e-9;

Vector place(const Selector& s, const SelectableBody& body, const Vec3& point) {
  const Vector x = to_eigen(point).transpose();
  return s.in_fractions ? Vector(body.low + x.cwiseProduct(body.high - body.low)) : x;
}

bool is_region(const Selector& s) {
  return s.kind == box || s.kind == sphere || s.kind == ellipsoid || s.kind == plane || s.kind == half_space;
}
/// How far a point lies outside of a region [m]; 0 inside.
double outside(const Selector& s, const SelectableBody& body, const Vector& x) {
  const Vector p = place(s, body, s.point);
  if (s.kind == box) return (p - x).cwiseMax(x - place(s, body, s.other)).cwiseMax(0).norm();
  if (s.kind == sphere) return std::max((x - p).norm() - s.length_m, 0.0);
  if (s.kind == ellipsoid) {  // along the line to the middle
    const double scaled = (x - p).cwiseQuotient(to_eigen(s.other).transpose()).norm();
    return scaled > 1 ? (x - p).norm() * (1 - 1 / scaled) : 0;
  }
  const double above = (x - p).dot(Vector(to_eigen(s.other).transpose().normalized()));
  return std::max(s.kind == plane ? std::abs(above) - s.length_m : above, 0.0);
}

/// The `candidates` among `points`, in their order, within `distance` of one of `targets`, which are nodes.
NodeList near_nodes(const Points& points, const NodeList& candidates, const Points& nodes, NodeList targets,
                    double distance) {
  std::sort(targets.begin(), targets.end(), [&](auto a, auto b) { return nodes(a, 0) < nodes(b, 0); });
  NodeList near;
  for (const std::int32_t i : candidates) {
    // Only targets with an x within the distance can be near.
    auto t = std::lower_bound(targets.begin(), targets.end(), points(i, 0),
                              [&](std::int32_t target, double x) { return x - nodes(target, 0) > distance; });
    while (t != targets.end() && nodes(*t, 0) - points(i, 0) <= distance &&
           (nodes.row(*t) - points.row(i)).norm() > distance)
      ++t;
    if (t != targets.end() && nodes(*t, 0) - points(i, 0) <= distance) near.push_back(i);
  }
  return near;
}

const NodeList& group_of(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  const auto& groups = body.in_cell ? body.mesh.cell_groups : body.mesh.groups;
  if (const auto found = groups.find(s.group); found != groups.end()) return found->second;
  std::string names;
  for (const auto& [known, nodes] : groups) names += (names.empty() ? "'" : ", '") + known + "'";
  const char* of_cells = body.in_cell ? " of cells" : "";
  throw input_error(wanted.place + "the mesh has no physical group" + of_cells + " for the " + wanted.nodes, s.group,
                    names.empty()
                        ? std::string("the mesh has no groups") + of_cells + ": select by box, sphere or plane"
                        : "use one of the groups of the mesh: " + names);
}

const NodeList& checked_nodes(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  for (const std::int32_t node : s.nodes)
    if (node >= body.mesh.n_nodes())
      throw input_error(wanted.place + "a node number of the " + wanted.nodes + " is out of range",
                        std::to_string(node), "give numbers from 0 to " + std::to_string(body.mesh.n_nodes() - 1));
  return s.nodes;
}

double spacing_of(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  if (s.length_m > 0 || s.count > 0) return s.length_m;
  if (!(body.tool_radius_m > 0))
    throw input_error(wanted.place + "spacing = \"auto\" needs a round tool, whose radius it follows",
                      "[probe] kind = \"node\"",
                      "give spacing_m or count, or [probe] kind = \"patch\" with tool_radius_m");
  return auto_spacing_of_radius * body.tool_radius_m;
}

NodeList spread_points(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  const NodeList nodes = nodes_to_spread_over(s, body, wanted);
  const auto count = static_cast<std::size_t>(s.count);
  if (count > nodes.size() && !nodes.empty())
    throw input_error(wanted.place + "count is larger than the number of nodes that it chooses from",
                      std::to_string(count) + " of " + std::to_string(nodes.size()),
                      "give at most " + std::to_string(nodes.size()) + ", a finer mesh, or a larger part in `within`");
  const double spacing = spacing_of(s, body, wanted);
  const NodeList kept = common(body.probed, nodes);
  const bool enough = count > 0 && kept.size() > count;
  NodeList chosen = spread_nodes(body.mesh.nodes, body.mesh.surface, enough ? kept : nodes, spacing, count,
                                 enough ? NodeList() : kept);
  if (count > 0 || chosen.size() >= 3 || nodes.size() == chosen.size()) return chosen;
  const std::string value = length_text(spacing) + ", of " + std::to_string(nodes.size()) + " nodes " +
                            std::to_string(chosen.size()) + " chosen";
  if (nodes.size() < 3)
    throw input_error(wanted.place + "the part of the surface is too small to spread points over", value,
                      "widen it until it has three nodes of the surface, or select its nodes without a spacing");
  constexpr int points_across = 8;  // any number that gives triangles on all of the part
  const double part_m = extent_of(body.mesh.nodes(nodes, Eigen::all)).norm(),
               proposed_m = std::min(part_m / points_across, spacing / 2);
  throw input_error(wanted.place + "the spacing is too large for the part of the surface that it is for", value,
                    "give a smaller spacing, such as " + length_text(proposed_m) +
                        ", or count = " + std::to_string(std::max<std::size_t>(chosen.size(), 1)) +
                        " if so few points are meant; is mesh.scale_to_m right?");
}

/// The nodes of a selector among the sorted `candidates`, which are all nodes or those of the surface, in any order.
/// Others may be among them.
NodeList pick(const Selector& s, const SelectableBody& body, const NodeList& candidates, const Wanted& wanted) {
  const auto part = [&](std::size_t i) { return select_nodes(s.of[i], body, wanted); };
  NodeList nodes;
  switch (s.kind) {
    case box:
    case sphere:
    case ellipsoid:
    case plane:
    case half_space:
      for (const auto i : candidates)
        if (outside(s, body, body.points->row(i)) <= body.slack_m) nodes.push_back(i);
      return nodes;
    case group:
      if (!body.in_cell) return group_of(s, body, wanted);
      for (const NodeList& cells = group_of(s, body, wanted); const auto i : candidates)
        if (std::ranges::binary_search(cells, (*body.in_cell)[static_cast<std::size_t>(i)])) nodes.push_back(i);
      return nodes;
    case SelectorKind::nodes:
      return checked_nodes(s, body, wanted);
    case nearest:
      return {*std::ranges::min_element(candidates, {}, [&, x = place(s, body, s.point)](std::int32_t i) {
        return (body.mesh.nodes.row(i) - x).squaredNorm();
      })};
    case surface:
      return body.surface;
    case free_surface:
      return without(body.surface, body.fixed);
    case SelectorKind::free:
      return without(candidates, body.fixed);
    case fixed:
      return body.fixed;
    case all:
      return candidates;
    case intersection:
    case difference:
      nodes = part(0);
      for (std::size_t i = 1; i < s.of.size(); ++i)
        nodes = s.kind == difference ? without(nodes, part(i)) : common(nodes, part(i));
      return nodes;
    case complement:
      return without(candidates, part(0));
    case near:
      return near_nodes(*body.points, candidates, body.mesh.nodes,
                        select_nodes(s.of[0], body.of_nodes ? *body.of_nodes : body, wanted),
                        s.length_m + body.slack_m);
    case spread:
      return spread_points(s, body, wanted);
  }
  return {};
}

std::string nearest_of_surface(const Selector& s, const SelectableBody& body) {
  const auto distance = [&](std::int32_t i) { return outside(s, body, body.points->row(i)); };
  const auto node = *std::ranges::min_element(body.in_cell ? body.every_node : body.surface, {}, distance);
  Vector x = body.points->row(node);
  const Vector size = body.high - body.low;
  for (int k = 0; s.in_fractions && k < 3; ++k) x(k) = size(k) > 0 ? (x(k) - body.low(k)) / size(k) : 0;
  return (body.in_cell ? "the middle of the nearest cell, " : "the nearest node of the surface is ") +
         std::to_string(node) + (body.in_cell ? ", is at " : " at ") + shown_text({x(0), x(1), x(2)}) +
         (s.in_fractions ? " (fractions of the bounding box), " : " m, ") + length_text(distance(node)) +
         " outside of it: move or widen it so far" + (body.in_cell ? ", or give smaller cells" : "");
}

/// A part is often missed because the unit of a mesh file is not that of the scene.
std::string size_text(const SelectableBody& body) {
  const Vector size = body.high - body.low;
  return ", so that the body measures " + shown_text({size(0), size(1), size(2)}) +
         " m; if that is not its size, correct scale_to_m in [mesh]";
}

std::string remedy_of_spread(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  const NodeList on_surface = common(select_nodes(s.of[0], body, wanted), body.surface);
  if (on_surface.empty()) return "give a part of the surface in `within`";
  double farthest_m = 0;
  for (const auto node : on_surface)
    farthest_m = std::max(
        farthest_m,
        (body.mesh.nodes(body.fixed, Eigen::all).rowwise() - body.mesh.nodes.row(node)).rowwise().norm().minCoeff());
  return "make from_fixed_m smaller than " + length_text(farthest_m) +
         ", the largest distance of these nodes from fixed ones, or `within` larger";
}

/// What to do if a selector selects no node of this body.
std::string remedy_if_empty(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  if (is_region(s)) return nearest_of_surface(s, body);
  if (s.kind == complement) return "every node is in what it excludes: exclude less";
  if (s.kind == spread) return remedy_of_spread(s, body, wanted);
  if (s.kind != intersection && s.kind != difference) return "select by other nodes or places";
  std::string parts;
  for (const auto& part : s.of) {
    const auto n = select_nodes(part, body, wanted).size();
    for (const auto& one : part)
      parts += (&one != &part.front() ? " or " : parts.empty() ? "" : ", ") + one.description;
    parts += " (" + std::to_string(n) + (n == 1 ? " node)" : " nodes)");
  }
  return s.kind == difference ? "nothing is left of the first of " + parts + ": widen the first or narrow the others"
                              : "no node is in all of " + parts + ": move or widen them until they overlap";
}

}  // namespace

NodeList common(const NodeList& a, const NodeList& b) {
  NodeList both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  return both;
}
NodeList without(const NodeList& a, const NodeList& b) {
  NodeList rest;
  std::ranges::set_difference(a, b, std::back_inserter(rest));
  return rest;
}

SelectableBody::SelectableBody(const Mesh& of)
    : mesh(of),
      points(&of.nodes),
      every_node(static_cast<std::size_t>(of.n_nodes())),
      surface(surface_nodes(of.surface)),
      low(of.nodes.colwise().minCoeff()),
      high(of.nodes.colwise().maxCoeff()),
      slack_m(on_the_border * (high - low).norm()) {
  std::iota(every_node.begin(), every_node.end(), 0);
}

SelectableBody::SelectableBody(const SelectableBody& nodes, const Points& of, const NodeList& cells)
    : SelectableBody(nodes) {
  points = &of, of_nodes = &nodes, in_cell = &cells;
  every_node.resize(cells.size());
  std::iota(every_node.begin(), every_node.end(), 0);
}

NodeList select_nodes(const Selection& selection, const SelectableBody& body, const Wanted& wanted) {
  NodeList nodes;
  for (const Selector& s : selection) {
    const Wanted own{wanted.nodes, s.where.file.empty() ? wanted.place : s.where.prefix()};
    NodeList more = pick(s, body, s.surface_only ? body.surface : body.every_node, own);
    sort_unique(more);
    if (s.surface_only) more = common(more, body.surface);
    if (more.empty()) {
      std::string remedy = remedy_if_empty(s, body, own);
      if (const auto inside = s.surface_only ? pick(s, body, body.every_node, own).size() : 0; inside > 0)
        remedy = "remove surface_only for the " + std::to_string(inside) +
                 " nodes that it selects inside the body; otherwise " + remedy;
      throw input_error(
          own.place + "a selector of the " + own.nodes + " selects no " + (body.in_cell ? "cell" : "node"),
          s.description,
          remedy + "; the mesh reaches from " + shown_text({body.low(0), body.low(1), body.low(2)}) + " to " +
              shown_text({body.high(0), body.high(1), body.high(2)}) + " m" + (is_region(s) ? size_text(body) : ""));
    }
    nodes.insert(nodes.end(), more.begin(), more.end());
  }
  sort_unique(nodes);
  return nodes;
}

NodeList nodes_to_spread_over(const Selector& s, const SelectableBody& body, const Wanted& wanted) {
  const NodeList on_surface = common(select_nodes(s.of[0], body, wanted), body.surface);
  if (!(s.from_fixed_m > 0)) return on_surface;
  const Points& nodes = body.mesh.nodes;
  return without(on_surface, near_nodes(nodes, on_surface, nodes, body.fixed, s.from_fixed_m - body.slack_m));
}

}  // namespace phynness::meshes
