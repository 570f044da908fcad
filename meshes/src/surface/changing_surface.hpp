// A closed triangulation that is changed in place by splits, collapses and flips of edges.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include "surface.hpp"
#include "topology.hpp"

namespace phynness::meshes {

/// Every operation keeps the surface closed and manifold; otherwise it is refused and returns false.
class ChangingSurface {
 public:
  using Vector = Eigen::RowVector3d;
  /// Edges are features if the cosine of the angle between the normals of their triangles is below `sharp_cosine`, but
  /// not those of an extent below `least_extent` that join no loop around more than one triangle: segmented organs have
  /// such ones by chance, while the ends of a pin or of a hole are loops.
  ChangingSurface(const Surface& surface, double sharp_cosine, double least_extent);

  std::vector<Edge> edges() const;
  /// The two triangles of an edge; empty if the edge no longer exists.
  std::optional<std::array<std::int32_t, 2>> triangles_of(const Edge& edge) const;
  bool is_feature(const Edge& edge) const { return _features.count(edge_of(edge[0], edge[1])) > 0; }
  /// Number of feature edges that meet at a node.
  int feature_degree(std::int32_t node) const { return _feature_degree[node]; }
  const std::vector<std::int32_t>& triangles_at(std::int32_t node) const { return _at[node]; }
  std::vector<std::int32_t> neighbours(std::int32_t node) const;
  bool exists(std::int32_t node) const { return !_at[node].empty(); }
  std::int32_t n_nodes() const { return static_cast<std::int32_t>(_x.size()); }
  double length(const Edge& edge) const { return (_x[edge[0]] - _x[edge[1]]).norm(); }
  const Vector& x(std::int32_t node) const { return _x[node]; }
  /// Nodes of a triangle; -1 if it was removed.
  const Triangle& triangle(std::int32_t t) const { return _triangles[t]; }
  std::int32_t n_triangles() const { return static_cast<std::int32_t>(_triangles.size()); }
  /// The node of a triangle that is not on the edge.
  std::int32_t opposite(std::int32_t t, const Edge& edge) const { return opposite(_triangles[t], edge); }
  static std::int32_t opposite(const Triangle& t, const Edge& edge) {
    return *std::find_if(t.begin(), t.end(), [&](std::int32_t node) { return node != edge[0] && node != edge[1]; });
  }
  void move(std::int32_t node, const Vector& x) { _x[node] = x; }
  /// Twice the area times the normal, with one node at another position.
  Vector area_vector(std::int32_t triangle, std::int32_t moved_node, const Vector& moved_to) const;
  Vector area_vector(std::int32_t triangle) const { return area_vector(triangle, -1, Vector::Zero()); }

  /// Adds a node at `x` to the edge.
  bool split(const Edge& edge, const Vector& x);
  /// Removes `gone` by moving it onto `kept`. Refused if the surface would touch itself, a triangle would be inverted
  /// or an edge would become longer than `longest`.
  bool collapse(std::int32_t gone, std::int32_t kept, double longest);
  /// Replaces the edge by one between the two opposite nodes. Refused on features and if a triangle would be inverted.
  bool flip(const Edge& edge);
  /// The same without conditions on features, angles and lengths: refused only if the surface would become
  /// non-manifold.
  bool collapse_anyhow(std::int32_t gone, std::int32_t kept);
  bool flip_anyhow(const Edge& edge);

  Surface surface() const;

 private:
  bool can_collapse(std::int32_t gone, std::int32_t kept) const;
  void replace(std::int32_t triangle, std::int32_t old_node, std::int32_t new_node);
  void set_feature(Edge edge, bool on);
  void remove_small_features(double least_extent);

  std::vector<Vector> _x;
  std::vector<Triangle> _triangles;  // a removed triangle has node -1
  std::vector<std::vector<std::int32_t>> _at;
  std::set<Edge> _features;
  std::vector<int> _feature_degree;
};

class ClosestPoint;
/// Collapses and flips edges at nearly flat triangles and at nearly closed outward folds, also across features that are
/// finer than the edge length. Each change improves the worst shape around it and is limited in distance and volume. A
/// surface without such shapes is not changed.
void remove_slivers(ChangingSurface& surface, const ClosestPoint& original, double edge_m);

}  // namespace phynness::meshes
