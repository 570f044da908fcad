#include "changing_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace phynness::meshes {
namespace {

// A triangle whose normal turns by more than this in an operation counts as inverted.
constexpr double least_normal_cosine = 0.5;

bool turned_over(const Eigen::RowVector3d& before, const Eigen::RowVector3d& after) {
  return before.dot(after) <= least_normal_cosine * before.norm() * after.norm();
}

}  // namespace

ChangingSurface::ChangingSurface(const Surface& surface, double sharp_cosine, double least_extent)
    : _at(static_cast<std::size_t>(surface.nodes.rows())), _feature_degree(_at.size(), 0) {
  for (Eigen::Index i = 0; i < surface.nodes.rows(); ++i) _x.push_back(surface.nodes.row(i));
  for (std::int32_t t = 0; t < surface.triangles.rows(); ++t) {
    _triangles.push_back({surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
    for (const std::int32_t node : _triangles.back()) _at[node].push_back(t);
  }
  for (const Edge& edge : edges()) {
    const auto pair = triangles_of(edge);
    const Vector a = area_vector((*pair)[0]), b = area_vector((*pair)[1]);
    if (a.dot(b) < sharp_cosine * a.norm() * b.norm()) set_feature(edge, true);
  }
  remove_small_features(least_extent);
}

void ChangingSurface::remove_small_features(double least_extent) {
  std::map<std::int32_t, std::vector<std::int32_t>> joined;
  for (const Edge& edge : _features)
    for (int k = 0; k < 2; ++k) joined[edge[k]].push_back(edge[1 - k]);
  while (!joined.empty()) {
    std::vector<std::int32_t> reached = {joined.begin()->first};
    std::vector<Edge> edges;  // each twice
    std::size_t n_nodes = 0;
    Eigen::AlignedBox3d extent;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const auto entry = joined.extract(reached[i]);
      if (entry.empty()) continue;
      ++n_nodes;
      extent.extend(_x[entry.key()].transpose());
      for (const auto other : entry.mapped()) {
        edges.push_back({entry.key(), other});
        reached.push_back(other);
      }
    }
    const bool has_loop = edges.size() / 2 >= n_nodes && n_nodes > 3;
    if (has_loop || extent.diagonal().norm() >= least_extent) continue;
    for (const Edge& edge : edges) set_feature(edge, false);
  }
}

void ChangingSurface::set_feature(Edge edge, bool on) {
  edge = edge_of(edge[0], edge[1]);
  const bool changed = on ? _features.insert(edge).second : _features.erase(edge) > 0;
  if (changed)
    for (const std::int32_t node : edge) _feature_degree[node] += on ? 1 : -1;
}

std::vector<Edge> ChangingSurface::edges() const {
  std::vector<Edge> list;
  for (const Triangle& t : _triangles)
    for (int k = 0; t[0] >= 0 && k < 3; ++k)
      if (t[k] < t[(k + 1) % 3]) list.push_back({t[k], t[(k + 1) % 3]});
  return list;
}

std::optional<std::array<std::int32_t, 2>> ChangingSurface::triangles_of(const Edge& edge) const {
  std::array<std::int32_t, 2> found{};
  int n = 0;
  for (const std::int32_t t : _at[edge[0]])
    if (std::find(_triangles[t].begin(), _triangles[t].end(), edge[1]) != _triangles[t].end() && n < 2) found[n++] = t;
  if (n != 2) return std::nullopt;
  return found;
}

std::vector<std::int32_t> ChangingSurface::neighbours(std::int32_t node) const {
  std::vector<std::int32_t> list;
  for (const std::int32_t t : _at[node])
    for (const std::int32_t other : _triangles[t])
      if (other != node && std::find(list.begin(), list.end(), other) == list.end()) list.push_back(other);
  return list;
}

Eigen::RowVector3d ChangingSurface::area_vector(std::int32_t triangle, std::int32_t moved_node,
                                                const Vector& moved_to) const {
  std::array<Vector, 3> p;
  for (int k = 0; k < 3; ++k) p[k] = _triangles[triangle][k] == moved_node ? moved_to : _x[_triangles[triangle][k]];
  return (p[1] - p[0]).cross(p[2] - p[0]);
}

void ChangingSurface::replace(std::int32_t triangle, std::int32_t old_node, std::int32_t new_node) {
  std::replace(_triangles[triangle].begin(), _triangles[triangle].end(), old_node, new_node);
  std::erase(_at[old_node], triangle);
  _at[new_node].push_back(triangle);
}

bool ChangingSurface::split(const Edge& edge, const Vector& x) {
  const auto pair = triangles_of(edge);
  if (!pair) return false;
  const auto middle = n_nodes();
  const bool feature = is_feature(edge);
  _x.push_back(x);
  _at.emplace_back();
  _feature_degree.push_back(0);
  for (const std::int32_t t : *pair) {
    // The old triangle keeps edge[0] and its copy gets edge[1], so that both keep the orientation of the old triangle.
    Triangle copy = _triangles[t];
    std::replace(copy.begin(), copy.end(), edge[0], middle);
    replace(t, edge[1], middle);
    const auto added = static_cast<std::int32_t>(_triangles.size());
    _triangles.push_back(copy);
    for (const std::int32_t node : copy) _at[node].push_back(added);
  }
  if (feature) {
    set_feature(edge, false);
    set_feature({edge[0], middle}, true);
    set_feature({middle, edge[1]}, true);
  }
  return true;
}

bool ChangingSurface::can_collapse(std::int32_t gone, std::int32_t kept) const {
  const auto pair = triangles_of({gone, kept});
  if (!pair) return false;
  const auto around_gone = neighbours(gone), around_kept = neighbours(kept);
  const auto common = std::count_if(around_gone.begin(), around_gone.end(), [&](std::int32_t node) {
    return std::find(around_kept.begin(), around_kept.end(), node) != around_kept.end();
  });
  if (common != 2) return false;  // the link condition; otherwise the surface would touch itself
  return std::all_of(pair->begin(), pair->end(), [&](std::int32_t t) {
    return _at[opposite(t, {gone, kept})].size() > 3;
  });
}

bool ChangingSurface::collapse(std::int32_t gone, std::int32_t kept, double longest) {
  if (!can_collapse(gone, kept)) return false;
  const auto pair = triangles_of({gone, kept});
  const auto around_kept = neighbours(kept);
  for (const std::int32_t node : neighbours(gone))
    if (node != kept && (_x[node] - _x[kept]).norm() > longest &&
        std::find(around_kept.begin(), around_kept.end(), node) == around_kept.end())
      return false;
  // A feature may only become shorter in its own direction; a side edge would otherwise coincide with another edge.
  if (feature_degree(gone) > 0 && !(is_feature({gone, kept}) && feature_degree(gone) == 2)) return false;
  for (const std::int32_t t : _at[gone])
    if (t != (*pair)[0] && t != (*pair)[1] && turned_over(area_vector(t), area_vector(t, gone, _x[kept]))) return false;
  return collapse_anyhow(gone, kept);
}

bool ChangingSurface::collapse_anyhow(std::int32_t gone, std::int32_t kept) {
  if (!can_collapse(gone, kept)) return false;
  const auto pair = triangles_of({gone, kept});
  for (const std::int32_t node : neighbours(gone)) {
    if (!is_feature({gone, node})) continue;
    set_feature({gone, node}, false);
    if (node != kept) set_feature({kept, node}, true);
  }
  for (const std::int32_t t : *pair) {
    for (const std::int32_t node : Triangle(_triangles[t])) std::erase(_at[node], t);
    _triangles[t] = {-1, -1, -1};
  }
  for (const std::int32_t t : std::vector<std::int32_t>(_at[gone])) replace(t, gone, kept);
  return true;
}

bool ChangingSurface::flip(const Edge& edge) {
  const auto pair = triangles_of(edge);
  if (!pair || is_feature(edge)) return false;
  const std::int32_t p = opposite((*pair)[0], edge), q = opposite((*pair)[1], edge);
  const Vector before = area_vector((*pair)[0]) + area_vector((*pair)[1]);
  // First triangle: edge[1] becomes q; second: edge[0] becomes p.
  const Vector first = area_vector((*pair)[0], edge[1], _x[q]), second = area_vector((*pair)[1], edge[0], _x[p]);
  if (turned_over(before, first) || turned_over(before, second)) return false;
  return flip_anyhow(edge);
}

bool ChangingSurface::flip_anyhow(const Edge& edge) {
  const auto pair = triangles_of(edge);
  if (!pair) return false;
  const std::int32_t p = opposite((*pair)[0], edge), q = opposite((*pair)[1], edge);
  if (p == q || _at[edge[0]].size() <= 3 || _at[edge[1]].size() <= 3 || triangles_of({p, q})) return false;
  set_feature(edge, false);
  // Both triangles keep their orientation.
  replace((*pair)[0], edge[1], q);
  replace((*pair)[1], edge[0], p);
  return true;
}

Surface ChangingSurface::surface() const {
  Surface result;
  std::vector<std::int32_t> position(_x.size(), -1);
  std::int32_t n = 0;
  for (std::size_t i = 0; i < _x.size(); ++i)
    if (!_at[i].empty()) position[i] = n++;
  result.nodes.resize(n, 3);
  for (std::size_t i = 0; i < _x.size(); ++i)
    if (position[i] >= 0) result.nodes.row(position[i]) = _x[i];
  std::vector<Triangle> alive;
  for (const Triangle& t : _triangles)
    if (t[0] >= 0) alive.push_back({position[t[0]], position[t[1]], position[t[2]]});
  result.triangles = to_matrix(alive);
  return result;
}

}  // namespace phynness::meshes
