#include <algorithm>
#include <phynness/formats/probe_points.hpp>
#include <phynness/planning/planning.hpp>

namespace phynness {
namespace {

/// The nodes of which a scene's probe points can be.
NodeList candidates(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  if (!spreads(scene.active)) return sets.active;
  SelectableBody body(mesh);
  body.fixed = sets.fixed;
  NodeList nodes = sets.active;
  for (const auto& selector : scene.active)
    for (const auto node : selector.choice->candidates(body, {body.surface, "active nodes", ""}))
      if (std::ranges::binary_search(body.surface, node) && !std::ranges::binary_search(sets.fixed, node))
        nodes.push_back(node);
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

std::vector<SpacingPlan> plan_spacings(const Scene& scene, const Mesh& mesh, const NodeSets& sets, double mean_edge_m) {
  if (scene.probe.kind != ProbeKind::patch) return {};
  const double auto_m = auto_spacing_of_radius * scene.probe.tool_radius_m;
  std::vector<SpacingPlan> plans{
      {auto_m, 0, false, 0.014, 0.055}, {auto_m / 2, 0, false, 0.0022, 0.011}, {2 * auto_m, 0, false, {}, {}}};
  const auto within = candidates(scene, mesh, sets);
  const auto image = sets.mirror ? sets.mirror->image : NodeList{};
  for (auto& plan : plans) {
    plan.points = std::ssize(spread_nodes(mesh.nodes, mesh.surface, within, plan.spacing_m, 0, image));
    plan.every_node = mean_edge_m > plan.spacing_m;
    if (plan.every_node) plan.mean = plan.p95 = {};
  }
  return plans;
}

}  // namespace phynness
