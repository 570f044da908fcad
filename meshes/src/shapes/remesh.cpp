#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "surface/changing_surface.hpp"
#include "surface/closest_point.hpp"

namespace phynness::meshes {
namespace {

constexpr double sharp_cosine = 0.6428;  // 50 degrees
constexpr int max_rounds = 40, smooth_rounds = 12;

std::vector<std::pair<double, Edge>> by_length(const ChangingSurface& surface, bool longest_first) {
  std::vector<std::pair<double, Edge>> list;
  for (const Edge& edge : surface.edges()) list.emplace_back((longest_first ? -1 : 1) * surface.length(edge), edge);
  std::sort(list.begin(), list.end());
  return list;
}

int split_long_edges(ChangingSurface& surface, const ClosestPoint& closest, double longest) {
  int changes = 0;
  for (const auto& [length, edge] : by_length(surface, true)) {
    if (surface.length(edge) <= longest) break;
    const Eigen::RowVector3d middle = (surface.x(edge[0]) + surface.x(edge[1])) / 2;
    changes += surface.split(edge, surface.is_feature(edge) ? middle : closest(middle));
  }
  return changes;
}

int collapse_short_edges(ChangingSurface& surface, double shortest, double longest) {
  int changes = 0;
  for (const auto& [length, edge] : by_length(surface, false)) {
    const auto [a, b] = edge;
    if (!surface.exists(a) || !surface.exists(b) || surface.length(edge) >= shortest) continue;
    // The node with fewer features is removed first; otherwise the other node is tried.
    const bool a_goes = surface.feature_degree(a) <= surface.feature_degree(b);
    const bool done = a_goes ? surface.collapse(a, b, longest) || surface.collapse(b, a, longest)
                             : surface.collapse(b, a, longest) || surface.collapse(a, b, longest);
    changes += done;
  }
  return changes;
}

void flip_towards_six(ChangingSurface& surface) {
  const auto excess = [&](std::int32_t node, int change) {
    const int deviation = static_cast<int>(surface.triangles_at(node).size()) + change - 6;
    return deviation * deviation;
  };
  for (const Edge& edge : surface.edges()) {
    const auto pair = surface.triangles_of(edge);
    if (!pair) continue;
    std::int32_t across[2] = {-1, -1};
    int found = 0;
    const auto near_b = surface.neighbours(edge[1]);
    for (const std::int32_t node : surface.neighbours(edge[0]))
      if (std::find(near_b.begin(), near_b.end(), node) != near_b.end() && found < 2) across[found++] = node;
    if (found < 2) continue;
    const int before = excess(edge[0], 0) + excess(edge[1], 0) + excess(across[0], 0) + excess(across[1], 0);
    const int after = excess(edge[0], -1) + excess(edge[1], -1) + excess(across[0], 1) + excess(across[1], 1);
    if (after < before) surface.flip(edge);
  }
}

void smooth(ChangingSurface& surface, const ClosestPoint& closest) {
  for (std::int32_t node = 0; node < surface.n_nodes(); ++node) {
    if (!surface.exists(node) || surface.feature_degree(node) > 0) continue;
    Eigen::RowVector3d normal = Eigen::RowVector3d::Zero(), center = normal;
    const auto around = surface.neighbours(node);
    for (const std::int32_t t : surface.triangles_at(node)) normal += surface.area_vector(t);
    for (const std::int32_t other : around) center += surface.x(other) / static_cast<double>(around.size());
    normal.normalize();
    const Eigen::RowVector3d shift = center - surface.x(node);
    const Eigen::RowVector3d wanted = closest(surface.x(node) + shift - shift.dot(normal) * normal);
    const bool sound = std::all_of(
        surface.triangles_at(node).begin(), surface.triangles_at(node).end(),
        [&](std::int32_t t) { return surface.area_vector(t).dot(surface.area_vector(t, node, wanted)) > 0; });
    if (sound) surface.move(node, wanted);
  }
}

}  // namespace

Surface remeshed(const Surface& original, double edge_m) {
  const ClosestPoint closest(original);
  // Smaller features are noise, unless the body is small.
  const double size = (original.nodes.colwise().maxCoeff() - original.nodes.colwise().minCoeff()).norm();
  ChangingSurface surface(original, sharp_cosine, std::min(2 * edge_m, size / 4));
  // With 4/3 and 4/5 neither a split nor a collapse makes an edge that is changed back immediately.
  const double longest = 4.0 / 3.0 * edge_m, shortest = 4.0 / 5.0 * edge_m;
  int good_rounds = 0;
  for (int round = 0; round < max_rounds && good_rounds < smooth_rounds; ++round) {
    const int splits = split_long_edges(surface, closest, longest);
    const int collapses = collapse_short_edges(surface, shortest, longest);
    flip_towards_six(surface);
    smooth(surface, closest);
    // A coarse input first needs rounds of splitting, which do not count as smoothing rounds.
    good_rounds += splits + collapses < surface.n_nodes() / 4;
  }
  remove_slivers(surface, closest, edge_m);
  return surface.surface();
}

}  // namespace phynness::meshes
