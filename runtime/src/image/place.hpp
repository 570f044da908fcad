// One round tool between active nodes (docs/theory.md, (x)): places on the surface, the nodes around them, and bounds.
#pragma once

#include "core/bound.hpp"
#include "image/image.hpp"

namespace PHN_IMAGES {

/// Largest number of triangles that a walk crosses, and of triangles around a vertex that it examines.
inline constexpr uint32_t most_crossings = 32, most_around_vertex = 64;

struct Nearest {
  uint32_t triangle;
  Real weight[3], point[3], square;  ///< square of the distance
};

/// Finds the place nearest to x on the surface.
class Search {
 public:
  Search(const Header& image, const image::Surface& surface, const Real* x)
      : _triangle(at<uint16_t>(image, surface.triangle)), _point(at<Real>(image, surface.point)), _x(x) {}

  Nearest everywhere(uint32_t n_triangles) const {
    Nearest best = on(0);
    for (uint32_t t = 1; t < n_triangles; ++t) keep_nearer(t, best);
    return best;
  }

  /// @param best  where the walk starts, then ends. @return whether it arrived
  bool walk(Nearest& best) const {
    for (uint32_t crossed = 0; crossed <= most_crossings; ++crossed)
      if (!step(best)) return true;
    return false;
  }

  [[gnu::noinline]] Nearest on(uint32_t t) const {
    Nearest found;
    const Real* corner[3];
    found.triangle = t;
    for (int k = 0; k < 3; ++k) corner[k] = _point + 3 * static_cast<size_t>(vertex(t, k));
    nearest_weights(corner, _x, found.weight);
    set_point(found);
    return found;
  }

  /// Whether x is on the inner side of the surface.
  [[gnu::cold]] bool is_inside(uint32_t n_triangles, const Nearest& found) const {
    const uint16_t corners[3] = {vertex(found.triangle, 0), vertex(found.triangle, 1), vertex(found.triangle, 2)};
    const Real away[3] = {_x[0] - found.point[0], _x[1] - found.point[1], _x[2] - found.point[2]};
    // Within a triangle its normal alone counts, so that no other triangle is looked at after a walk.
    const bool within = found.weight[0] > 0 && found.weight[1] > 0 && found.weight[2] > 0;
    const auto vertex_of = [&](uint32_t t, int k) { return within ? corners[k] : vertex(t, k); };
    const auto point_of = [this](uint16_t v) { return _point + 3 * static_cast<size_t>(v); };
    return height_above(within ? 1 : n_triangles, vertex_of, point_of, corners, found.weight, away) < 0;
  }

  /// Moves a place away from a fixed edge. @param corners  of the vertices
  [[gnu::cold]] void leave_fixed_edge(const image::VertexCorners* corners, Nearest& found) const {
    bool moves[3];
    Real movable = 0;
    for (int k = 0; k < 3; ++k) {
      moves[k] = corners[vertex(found.triangle, k)].active[0] != image::none;
      movable += moves[k] ? found.weight[k] : 0;
    }
    if (raise_movable_weight(moves, 3, movable, found.weight)) set_point(found);
  }

 private:
  /// Sets the point of the weights and its distance.
  void set_point(Nearest& found) const {
    found.square = 0;
    for (int k = 0; k < 3; ++k) {
      found.point[k] = 0;
      for (int c = 0; c < 3; ++c)
        found.point[k] +=
            found.weight[c] * _point[3 * static_cast<size_t>(vertex(found.triangle, c)) + static_cast<size_t>(k)];
      found.square += (_x[k] - found.point[k]) * (_x[k] - found.point[k]);
    }
  }
  uint16_t vertex(uint32_t t, int k) const { return _triangle[6 * t + static_cast<uint32_t>(k)]; }
  uint16_t across(uint32_t t, int k) const { return vertex(t, 3 + k); }

  bool keep_nearer(uint32_t t, Nearest& best) const {
    const Nearest found = on(t);
    const bool nearer = found.square < best.square;
    if (nearer) best = found;
    return nearer;
  }

  /// Moves to a nearer triangle at the edge or the vertex on which the nearest point is. Distances only decrease, so
  /// that no triangle is entered twice. @return whether there was one
  bool step(Nearest& best) const {
    const Real* w = best.weight;
    for (int k = 0; k < 3; ++k)
      if (w[k] == 1) return nearer_around(k, 1, best) || nearer_around(k, 2, best);
    for (int k = 0; k < 3; ++k) {
      const uint16_t next = across(best.triangle, k);
      if (w[k] == 0 && next != image::none && keep_nearer(next, best)) return true;
    }
    return false;
  }

  /// Examines the triangles around corner k, from the one across the edge opposite to the corner k + turn.
  [[gnu::noinline]] bool nearer_around(int k, int turn, Nearest& best) const {
    const uint16_t middle = vertex(best.triangle, k);
    uint32_t t = best.triangle;
    for (uint32_t i = 0; i < most_around_vertex; ++i) {
      t = across(t, (k + turn) % 3);
      if (t == image::none || t == best.triangle) return false;
      if (keep_nearer(t, best)) return true;
      for (k = 0; k < 3 && vertex(t, k) != middle;) ++k;
      if (k == 3) return false;
    }
    return false;
  }

  const uint16_t* _triangle;
  const Real *_point, *_x;
};

/// Weights of positions (see active_node). @tparam most  largest number
template <uint32_t most>
struct Weights {
  uint32_t n = 0;
  uint32_t position[most];
  Real weight[most];

  void add(uint32_t at, Real by) {
    uint32_t i = 0;
    while (i < n && position[i] != at) ++i;
    if (i == n) {
      position[n++] = at;
      weight[i] = 0;
    }
    weight[i] += by;
  }
};

/// The active node of a tool, or the active nodes and linear points between which it is. The weights have the sum 1.
struct Corners : Weights<image::most_corners> {
  Real fixed_weight = 0;
  Real point[3];  ///< on the surface, between nodes; of fixed corners' weights the others take shares

  bool counts(uint32_t i) const { return weight[i] > Real(least_share); }
};

/// Checks a place and finds its corners. @return a status of phynness.h
[[gnu::cold]] inline int find_between(const Header& image, const phn_image_tool& tool, Corners& corners) {
  constexpr Real slack = Real(1e-6), whole = schema::whole_weight;
  const image::Surface* surface = surface_of(image);
  if (surface == nullptr) return PHN_ERROR_UNDEFINED;
  const auto triangle = static_cast<uint32_t>(tool.triangle);
  if (triangle >= surface->triangle.n / 6) return PHN_ERROR_ARGUMENT;
  const auto* vertex = at<uint16_t>(image, surface->triangle) + 6 * static_cast<size_t>(triangle);
  Real sum = 0, movable = 0;
  for (Real& x : corners.point) x = 0;
  for (int k = 0; k < 3; ++k) {
    const Real w = tool.weights[k];
    if (!(w >= 0 && w <= 1 + slack)) return PHN_ERROR_ARGUMENT;
    sum += w;
    const auto& corner = at<image::VertexCorners>(image, surface->vertex)[vertex[k]];
    if (w == 0 || corner.active[0] == image::none) continue;
    movable += w;
    for (int i = 0; i < 3; ++i) corners.point[i] += w * at<Real>(image, surface->point)[3 * vertex[k] + i];
    const Real first = w * (corner.first / whole), second = (w - first) * (corner.second / whole);
    const Real part[3] = {first, second, w - first - second};
    for (int i = 0; i < 3; ++i)
      if (part[i] > 0) corners.add(corner.active[i], part[i]);
  }
  if (!(sum >= 1 - slack && sum <= 1 + slack)) return PHN_ERROR_ARGUMENT;
  if (!(movable > slack)) return PHN_ERROR_NOT_ACTIVE;
  corners.fixed_weight = sum - movable;
  for (Real& x : corners.point) x /= movable;
  for (uint32_t i = 0; i < corners.n; ++i) corners.weight[i] /= movable;
  return PHN_OK;
}

/// @return a status of phynness.h
inline int find_corners(const Header& image, const phn_image_tool& tool, Corners& corners) {
  if (tool.node == -1) return find_between(image, tool, corners);
  const auto n_active = static_cast<int32_t>(image.active_nodes.n);
  const int32_t found = find_sorted(at<int32_t>(image, image.active_nodes), n_active, tool.node);
  corners.n = 1;
  corners.position[0] = static_cast<uint32_t>(found);
  corners.weight[0] = 1;
  return found < 0 ? PHN_ERROR_NOT_ACTIVE : PHN_OK;
}

/// The corners and, behind them, their neighbours, with the weights of (x).
using Neighbourhood = Weights<image::most_corners*(1 + image::most_neighbours)>;

/// Sets the weights of (x) by the gradients of the energies over the surface, as mean_at in tools/round_tool.cpp.
[[gnu::cold]] inline void find_neighbours(const Header& image, const Corners& corners, Neighbourhood& around) {
  const image::Surface& surface = *surface_of(image);
  const Real* point[image::most_corners];
  Real x[3] = {0, 0, 0}, away[3], squares = 0, square = 0;
  around.n = corners.n;
  for (uint32_t i = 0; i < corners.n; ++i) {
    const size_t n_active = image.active_nodes.n, own = corners.position[i];
    point[i] = own < n_active ? at<Real>(image, image.active_points) + 3 * own
                              : at<Real>(image, surface.rest_point) + 3 * (own - n_active);
    around.position[i] = corners.position[i];
    around.weight[i] = corners.weight[i];
    for (int k = 0; k < 3; ++k) {
      const Real from = corners.point[k] - point[i][k];
      x[k] += corners.weight[i] * point[i][k];
      squares += corners.weight[i] * from * from;
    }
  }
  for (int k = 0; k < 3; ++k) {
    away[k] = corners.point[k] - x[k];
    square += away[k] * away[k];
  }
  // The slopes have the factor 1/2.
  const Real twice = squares > 0 ? 2 * (squares - square) / (squares + square) : 0;
  for (int k = 0; k < 3; ++k) x[k] += twice * away[k];
  for (uint32_t i = 0; i < corners.n; ++i) {
    const uint32_t* begin = at<uint32_t>(image, surface.begin) + corners.position[i];
    for (int k = 0; k < 3; ++k) away[k] = x[k] - point[i][k];
    for (uint32_t m = begin[0]; m < begin[1]; ++m) {
      const Real part = corners.weight[i] * dot(away, at<Real>(image, surface.slope) + 3 * static_cast<size_t>(m));
      around.add(at<uint16_t>(image, surface.neighbour)[m], part);
      around.weight[i] -= part;
    }
  }
}

/// Bound of the force at one active node. @param d  clamped, inside the trained range
inline Real bound_at_node(const Header& image, const image::Surface& surface, uint32_t active, const Real* d) {
  const uint32_t n_rows = image.displacements.n / 3, n = n_rows / (image.directions.n / 3);
  const Real* directions = at<Real>(image, image.directions);
  uint32_t nearest = 0;
  for (uint32_t i = 1; i < image.directions.n / 3; ++i)
    if (dot(d, directions + 3 * i) > dot(d, directions + 3 * nearest)) nearest = i;
  const size_t first = static_cast<size_t>(nearest) * n;
  const bool modal = traits(image).has_modes;
  const Real x[3] = {modal ? d[0] / image.max_displacement : d[0], modal ? d[1] / image.max_displacement : d[1],
                     modal ? d[2] / image.max_displacement : d[2]};
  const auto rest = [&] {  // The bound at rest is the size of the force.
    const Real none[3] = {0, 0, 0};
    Real force[3] = {0, 0, 0};
    if (!modal) respond<Force>(image, active, none, force);
    return square_root(dot(force, force));
  };
  return bound_along(at<Real>(image, image.displacements) + 3 * first, static_cast<int32_t>(n),
                     at<int16_t>(image, surface.bound) + static_cast<size_t>(active) * n_rows + first,
                     at<Real>(image, surface.bound_scale)[active], dot(x, x), rest);
}

}  // namespace PHN_IMAGES
