#include <Eigen/Eigenvalues>
#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/meshes/tool_weights.hpp>

#include "probes/select_nodes.hpp"
#include "surface/topology.hpp"

namespace phynness {
namespace {

std::string listed(const NodeList& nodes) {
  return std::to_string(nodes.size()) + " nodes: " + meshes::first_few(nodes, 5);
}

/// Whether some nodes are those of one mesh, so that another one of the body has none in their place.
bool is_of_one_mesh(const Selection& selection) {
  return std::ranges::any_of(selection, [](const Selector& s) {
    return s.kind == SelectorKind::nodes || s.kind == SelectorKind::nearest || s.kind == SelectorKind::spread ||
           std::ranges::any_of(s.of, is_of_one_mesh);
  });
}

NodeList held_nodes(const Scene& scene, const meshes::SelectableBody& body) {
  auto fixed = meshes::select_nodes(scene.fixed, body, {"fixed nodes", scene.fixed_where.prefix()});
  if (!hold_the_body(body.mesh, fixed))
    throw input_error(scene.fixed_where.prefix() + "the fixed nodes do not prevent rotations of the body",
                      listed(fixed), "fix at least three nodes that are not on one line");
  return fixed;
}

}  // namespace

NodeList resolve_fixed(const Scene& scene, const Mesh& other) {
  if (is_of_one_mesh(scene.fixed))
    throw input_error(scene.fixed_where.prefix() + "fixed nodes of one mesh cannot be found on another one", "",
                      "select them by a box, a sphere or a half-space");
  return held_nodes(scene, meshes::SelectableBody(other));
}

bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed) {
  std::vector<char> held(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const auto node : fixed) held[static_cast<std::size_t>(node)] = 1;
  const auto is_held = [&](Eigen::Index c, int k) { return held[static_cast<std::size_t>(mesh.cells(c, k))]; };
  for (Eigen::Index c = 0; mesh.cells.cols() == 3 && c < mesh.cells.rows(); ++c)
    if (is_held(c, 0) + is_held(c, 1) + is_held(c, 2) > 1) return true;
  if (fixed.size() < 3) return false;
  Points at = mesh.nodes(fixed, Eigen::all);
  at.rowwise() -= Eigen::RowVector3d(at.colwise().mean());
  // Eigenvalues: mean square distances from the best plane, within this plane from the best line, and along this line.
  const Eigen::Matrix3d spread = at.transpose() * at / static_cast<double>(fixed.size());
  const auto squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const Eigen::RowVector3d extent = mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff();
  return squares[1] > 1e-12 * extent.squaredNorm();
}

NodeSets resolve_selections(const Scene& scene, const Mesh& mesh) {
  NodeSets sets;
  resolve_selections(scene, mesh, sets);
  return sets;
}

void resolve_selections(const Scene& scene, const Mesh& mesh, NodeSets& sets, const NodeList& probed) {
  if (mesh.nodes.rows() == 0) throw input_error("cannot select nodes: the mesh is empty", "", "give a mesh with cells");
  meshes::SelectableBody body(mesh);
  const auto nodes_of = [&](const Selection& selection, const char* what, const SourceLocation& where) {
    return meshes::select_nodes(selection, body, {what, where.prefix()});
  };
  body.fixed = sets.fixed = held_nodes(scene, body);
  body.tool_radius_m = scene.probe.tool_radius_m;
  if (std::ranges::includes(sets.fixed, body.surface))
    throw input_error(scene.fixed_where.prefix() + "every node of the surface is fixed, so that nothing can be touched",
                      std::to_string(sets.fixed.size()) + " of " + std::to_string(mesh.n_nodes()) + " nodes",
                      "fix a part of the body only");
  body.probed = probed;
  sets.active = nodes_of(scene.active, "active nodes", scene.active_where);
  body.probed.clear();
  sets.output = nodes_of(scene.output, "output nodes", scene.output_where);
  const auto unknown = meshes::without(meshes::without(body.every_node, sets.fixed), sets.output).size();
  if (scene.probe.tools > 1 && unknown > 0)
    throw input_error(scene.output_where.prefix() + "[probe] tools needs the displacements of all nodes",
                      std::to_string(unknown) + " nodes are neither output nodes nor fixed",
                      "write output = \"free\" in [nodes], or remove tools");
  if (const NodeList both = meshes::common(sets.fixed, sets.active); !both.empty())
    throw input_error(
        scene.active_where.prefix() + "active nodes that are also fixed cannot be displaced", listed(both),
        both.size() == sets.active.size()
            ? "every active node is fixed: select others, such as \"free-surface\", or fix fewer nodes"
            : "remove them by active = { difference = [ SELECTION, \"fixed\" ] }, or use \"free-surface\"");
  if (const NodeList inside = meshes::without(sets.active, body.surface); !inside.empty())
    throw input_error(scene.active_where.prefix() + "active nodes inside the body cannot be touched", listed(inside),
                      inside.size() == sets.active.size()
                          ? "no active node is on the surface: select nodes of it, such as \"free-surface\""
                          : "add surface_only = true to the selector, or use \"free-surface\"");
  sets.tools = tools_of(mesh, sets.fixed, sets.active, scene.probe.tool_radius_m);
  select_elsewhere(scene, mesh, sets);
}

void select_elsewhere(const Scene& scene, const Mesh& mesh, NodeSets& sets) {
  sets.linear.clear();
  if (scene.probe.kind == ProbeKind::patch && scene.probe.elsewhere == Elsewhere::linear) {
    const double given_m = spacing_m(scene.active), radius_m = scene.probe.tool_radius_m;
    const auto spread_over = [&](const NodeList& part, const NodeList& kept) {
      return spread_nodes(mesh.nodes, mesh.surface, part, given_m > 0 ? given_m : auto_spacing_of_radius * radius_m, 0,
                          kept);
    };
    const NodeList free = meshes::without(surface_nodes(mesh.surface), sets.fixed);
    sets.linear = meshes::without(spread_over(free, sets.active), sets.active);
    // Over sharp edges tools are not answered by the points around them, however near these are.
    if (spreads(scene.active)) {
      const auto more = spread_over(without_coordinates(mesh, sets, radius_m), {});
      sets.linear.insert(sets.linear.end(), more.begin(), more.end());
      sort_unique(sets.linear);
    }
  }
  sets.linear_tools = tools_of(mesh, sets.fixed, sets.linear, scene.probe.tool_radius_m);
}

}  // namespace phynness
