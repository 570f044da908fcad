#include "eval_refusals.hpp"

#include <algorithm>
#include <cmath>

namespace phynness::cli {
namespace {

/// The tool radius [m] from the weight that determines it best; 0: every patch holds only its own node.
double radius_of_patches(const LoadedModel& loaded) {
  const Points& nodes = loaded.mesh().nodes;
  double radius = 0, nearest = 1;
  for (const auto& active : loaded.model().nodes)
    for (std::size_t i = 0; i < active.prescribed.size(); ++i) {
      const double weight = active.prescribed_weight[i], from_half = std::abs(weight - 0.5);
      if (active.prescribed[i] == active.node || !(weight > 0 && weight < 1) || from_half >= nearest) continue;
      nearest = from_half;
      // Of patch_weight(): weight = (1 - s2)^2 with s2 = (distance / radius)^2.
      radius = (nodes.row(active.prescribed[i]) - nodes.row(active.node)).norm() / std::sqrt(1 - std::sqrt(weight));
    }
  return radius;
}

}  // namespace

void refuse_as_solve(const LoadedModel& loaded, const std::vector<SurfacePoint>& places) {
  const Model& model = loaded.model();
  const double radius = radius_of_patches(loaded);
  if (!(radius > 0)) return;
  for (const auto& place : places)
    touched_nodes(loaded.mesh().nodes, loaded.mesh().surface, model.fixed, place, radius);
  if (places.size() < 2) return;
  require_apart(places, model.fixed, [&](std::int32_t node) {
    const auto it = std::lower_bound(model.nodes.begin(), model.nodes.end(), node,
                                     [](const ActiveNodeModel& active, std::int32_t n) { return active.node < n; });
    return it != model.nodes.end() && it->node == node ? it->prescribed : std::vector<std::int32_t>{};
  });
}

}  // namespace phynness::cli
