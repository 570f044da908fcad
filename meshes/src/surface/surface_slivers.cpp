// Flat triangles and thin folds of a remeshed surface, which prevent tetrahedra of good quality.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "changing_surface.hpp"
#include "closest_point.hpp"
#include "geometry.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;

// Shape: radius ratio of a triangle; of a fold half of 1 + the cosine between its normals (0.15: 45 degrees inside).
constexpr double bad_shape = 0.15;
constexpr int most_passes = 10;
// In edge lengths, and in cubes of edge lengths (a regular tetrahedron has 0.118).
constexpr double most_distance = 0.3, most_volume = 0.03;

/// Triangles that replace others with the same boundary.
struct Change {
  std::vector<std::int32_t> removed;
  std::vector<Triangle> added;
  Edge edge{};  ///< the edge to be flipped, or the edge from the removed node to the kept node
  bool is_flip = false;
};

class SliverRemoval {
 public:
  SliverRemoval(ChangingSurface& surface, const ClosestPoint& original, double edge_m)
      : _surface(surface), _original(original), _edge_m(edge_m) {}

  /// One pass over all triangles. @return number of changes
  int pass() {
    int changes = 0;
    for (std::int32_t t = 0; t < _surface.n_triangles(); ++t)
      if (_surface.triangle(t)[0] >= 0 && shape({_surface.triangle(t)}, {t}) < bad_shape) changes += improve(t);
    return changes;
  }

 private:
  Vector normal(const Triangle& t) const {
    const Vector a = _surface.x(t[0]);
    return (_surface.x(t[1]) - a).cross(_surface.x(t[2]) - a);
  }

  double triangle_shape(const Triangle& t) const {
    const Vector a = _surface.x(t[0]);
    return radius_ratio(_surface.x(t[1]) - a, _surface.x(t[2]) - a);
  }

  /// 1 if the triangles lie in a plane or enclose a notch, 0 if they coincide with the body between them.
  double fold_shape(const Triangle& t, const Triangle& other, std::int32_t other_node) const {
    const Vector n = normal(t), m = normal(other);
    if ((_surface.x(other_node) - _surface.x(t[0])).dot(n) >= 0) return 1;
    const double size = n.norm() * m.norm();
    return size > 0 ? (1 + n.dot(m) / size) / 2 : 0;
  }

  static bool has(const Triangle& t, std::int32_t node) { return std::find(t.begin(), t.end(), node) != t.end(); }

  /// The other triangle at an edge, from `triangles` or from the surface without `removed`.
  const Triangle* across(const Edge& edge, std::size_t index, const std::vector<Triangle>& triangles,
                         const std::vector<std::int32_t>& removed) const {
    for (std::size_t i = 0; i < triangles.size(); ++i)
      if (i != index && has(triangles[i], edge[0]) && has(triangles[i], edge[1])) return &triangles[i];
    for (const std::int32_t t : _surface.triangles_at(edge[0]))
      if (has(_surface.triangle(t), edge[1]) && std::find(removed.begin(), removed.end(), t) == removed.end())
        return &_surface.triangle(t);
    return nullptr;
  }

  /// The worst shape of triangles and of their folds, without the triangles `removed`.
  double shape(const std::vector<Triangle>& triangles, const std::vector<std::int32_t>& removed) const {
    double worst = 1;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Triangle& t = triangles[i];
      worst = std::min(worst, triangle_shape(t));
      for (int k = 0; k < 3; ++k) {
        const Edge edge{t[k], t[(k + 1) % 3]};
        if (const Triangle* other = across(edge, i, triangles, removed))
          worst = std::min(worst, fold_shape(t, *other, ChangingSurface::opposite(*other, edge)));
      }
    }
    return worst;
  }

  std::vector<Triangle> triangles_of(const std::vector<std::int32_t>& list) const {
    std::vector<Triangle> triangles;
    for (const std::int32_t t : list) triangles.push_back(_surface.triangle(t));
    return triangles;
  }

  double volume(const std::vector<Triangle>& triangles, const Vector& origin) const {
    double six = 0;
    for (const Triangle& t : triangles) six += (_surface.x(t[0]) - origin).dot(normal(t));
    return six / 6;
  }

  bool stays_close(const Change& change) const {
    const Vector origin = _surface.x(change.edge[0]);
    const double moved = volume(triangles_of(change.removed), origin) - volume(change.added, origin);
    if (std::abs(moved) > most_volume * std::pow(_edge_m, 3)) return false;
    const auto near = [&](const Vector& x) { return (_original(x) - x).norm() <= most_distance * _edge_m; };
    return std::all_of(change.added.begin(), change.added.end(), [&](const Triangle& t) {
      const Vector &a = _surface.x(t[0]), &b = _surface.x(t[1]), &c = _surface.x(t[2]);
      return near((a + b + c) / 3) && near((a + b) / 2) && near((b + c) / 2) && near((c + a) / 2);
    });
  }

  void add_flip(const Edge& edge, std::vector<Change>& changes) const {
    const auto pair = _surface.triangles_of(edge);
    if (!pair) return;
    Change change{{(*pair)[0], (*pair)[1]}, triangles_of({(*pair)[0], (*pair)[1]}), edge, true};
    const std::int32_t p = _surface.opposite((*pair)[0], edge), q = _surface.opposite((*pair)[1], edge);
    std::replace(change.added[0].begin(), change.added[0].end(), edge[1], q);
    std::replace(change.added[1].begin(), change.added[1].end(), edge[0], p);
    changes.push_back(std::move(change));
  }

  void add_collapse(std::int32_t gone, std::int32_t kept, std::vector<Change>& changes) const {
    Change change{_surface.triangles_at(gone), {}, {gone, kept}, false};
    for (const Triangle& t : triangles_of(change.removed)) {
      if (has(t, kept)) continue;
      change.added.push_back(t);
      std::replace(change.added.back().begin(), change.added.back().end(), gone, kept);
    }
    changes.push_back(std::move(change));
  }

  /// Applies the best change at a triangle, if it improves the shape.
  bool improve(std::int32_t t) {
    std::vector<Change> changes;
    const Triangle nodes = _surface.triangle(t);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = nodes[k], b = nodes[(k + 1) % 3];
      add_flip({a, b}, changes);
      add_collapse(a, b, changes);
      add_collapse(b, a, changes);
    }
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const double before = shape(triangles_of(changes[i].removed), changes[i].removed);
      const double after = shape(changes[i].added, changes[i].removed);
      if (after > 1.5 * before && stays_close(changes[i])) order.emplace_back(-after, i);
    }
    std::sort(order.begin(), order.end());
    return std::any_of(order.begin(), order.end(), [&](const auto& entry) {
      const Change& change = changes[entry.second];
      return change.is_flip ? _surface.flip_anyhow(change.edge)
                            : _surface.collapse_anyhow(change.edge[0], change.edge[1]);
    });
  }

  ChangingSurface& _surface;
  const ClosestPoint& _original;
  double _edge_m;
};

}  // namespace

void remove_slivers(ChangingSurface& surface, const ClosestPoint& original, double edge_m) {
  SliverRemoval removal(surface, original, edge_m);
  for (int pass = 0; pass < most_passes && removal.pass() > 0; ++pass) {
  }
}

}  // namespace phynness::meshes
