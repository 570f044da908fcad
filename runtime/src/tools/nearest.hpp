// The place nearest to a point among the places of a surface where a tool can be.
#pragma once

#include <phynness/phynness.h>

#include "tools/triangle.hpp"

namespace PHN_RUNTIME {

/// Where a tool can be: not at the vertex, only at the vertex itself, or in triangles with this movable or fixed
/// vertex.
enum class VertexKind { untouchable, node_only, movable, fixed };

/// Components of points are clamped to this [m].
inline constexpr double largest_place = 1e60;

/// Vertices with barycentric weights. The first vertex that is -1 ends them.
struct NearestPlace {
  std::int32_t vertex[3];
  bool moves[3];
  double weight[3], point[3], distance;  ///< distance < 0: there is none
  bool is_inside;                        ///< whether the point that was given is inside of the body
};

/// Replaces `best` by the point of up to three vertices that is nearest to x, if that is nearer.
template <class PointOf>
void keep_nearer(const double* x, const std::int32_t* vertex, const bool* moves, int n, const PointOf& point_of,
                 NearestPlace& best) {
  // A segment or a point is a triangle whose other corners are the first; nearest_weights gives these no weight.
  const double* corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = point_of(vertex[k < n ? k : 0]);
  NearestPlace found = {};
  nearest_on_triangle(corner, x, found.weight, found.point, found.distance);
  if (best.distance >= 0 && found.distance >= best.distance) return;
  for (int k = 0; k < 3; ++k) {
    found.vertex[k] = k < n ? vertex[k] : -1;
    found.moves[k] = k < n && moves[k];
  }
  best = found;
}

/// Whether the box of a triangle is farther from x than some distance, by more than rounding errors.
inline bool is_farther(const double* const corner[3], const double* x, double distance) {
  double squared = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    const double a = corner[0][k], b = corner[1][k], c = corner[2][k];
    const double ab_low = a < b ? a : b, ab_high = a < b ? b : a;
    const double low = ab_low < c ? ab_low : c, high = ab_high > c ? ab_high : c;
    const double below = low - x[k], above = x[k] - high, outside = below > above ? below : above;
    const double gap = outside > 0 ? outside : 0;
    squared += gap * gap;
    size += high - low;
  }
  constexpr double rounding = 1e-9;
  const double reach = (1 + rounding) * distance + rounding * size;
  return squared > reach * reach;
}

/// The nearest place, moved away from a fixed edge until moving corners have smallest_movable_weight.
/// @param point_of  coordinates of a vertex
/// @param kind_of   VertexKind of a vertex
template <class PointOf, class KindOf>
NearestPlace nearest_place(const std::int32_t* triangles, std::int32_t n_triangles, const double* x,
                           const PointOf& point_of, const KindOf& kind_of) {
  NearestPlace best = {{-1, -1, -1}, {}, {}, {}, -1, false}, any = best;  // any: of the whole surface
  for (std::int32_t t = 0; t < n_triangles; ++t) {
    const std::int32_t* vertex = triangles + 3 * static_cast<std::size_t>(t);
    const double* const corner[3] = {point_of(vertex[0]), point_of(vertex[1]), point_of(vertex[2])};
    if (best.distance >= 0 && is_farther(corner, x, best.distance)) continue;
    double weight[3], nearest[3], distance = 0;
    nearest_on_triangle(corner, x, weight, nearest, distance);
    if (any.distance < 0 || distance < any.distance)
      any = {{vertex[0], vertex[1], vertex[2]},    {},       {weight[0], weight[1], weight[2]},
             {nearest[0], nearest[1], nearest[2]}, distance, false};
    if (best.distance >= 0 && distance >= best.distance) continue;
    std::int32_t vertices[3];
    bool moves[3], has_movable = false;
    int n = 0;
    for (int k = 0; k < 3; ++k) {
      const VertexKind kind = kind_of(vertex[k]);
      const bool is_free = kind == VertexKind::movable, moves_node = true;
      if (kind == VertexKind::node_only) keep_nearer(x, vertex + k, &moves_node, 1, point_of, best);
      if (!is_free && kind != VertexKind::fixed) continue;
      has_movable = has_movable || is_free;
      moves[n] = is_free;
      vertices[n++] = vertex[k];
    }
    if (has_movable) keep_nearer(x, vertices, moves, n, point_of, best);
  }
  if (best.distance < 0) return best;
  double difference[3] = {x[0] - any.point[0], x[1] - any.point[1], x[2] - any.point[2]};
  // Within a triangle its normal alone counts.
  const bool within = any.weight[0] > 0 && any.weight[1] > 0 && any.weight[2] > 0;
  const std::int32_t* const around = within ? any.vertex : triangles;
  const auto vertex_of = [&](std::uint32_t t, int k) { return around[3 * static_cast<std::size_t>(t) + k]; };
  best.is_inside = height_above(within ? 1 : static_cast<std::uint32_t>(n_triangles), vertex_of, point_of, any.vertex,
                                any.weight, difference) < 0;
  int n = 0;
  double movable = 0;
  for (; n < 3 && best.vertex[n] >= 0; ++n) movable += best.moves[n] ? best.weight[n] : 0;
  if (!raise_movable_weight(best.moves, n, movable, best.weight)) return best;
  for (int k = 0; k < 3; ++k) {
    best.point[k] = 0;
    for (int c = 0; c < n; ++c) best.point[k] += best.weight[c] * point_of(best.vertex[c])[k];
    difference[k] = x[k] - best.point[k];
  }
  best.distance = length(difference);
  return best;
}

/// phn_nearest or phn_body_nearest. @param find  NearestPlace of a point. @param node_of  number of a vertex in the
/// mesh
template <class Find, class NodeOf>
int answer_nearest(bool has_surface, const double* x, phn_tool* tool, double* point, double* distance, const Find& find,
                   const NodeOf& node_of) {
  NearestPlace found = {{-1, -1, -1}, {}, {0, 0, 0}, {0, 0, 0}, 0, false};
  int status = PHN_ERROR_ARGUMENT;
  if (has_surface && x != nullptr && tool != nullptr) {
    status = PHN_OK;
    if (overlap(tool, sizeof *tool, point, 3 * sizeof *point) ||
        overlap(tool, sizeof *tool, distance, sizeof *distance) ||
        overlap(point, 3 * sizeof *point, distance, sizeof *distance))
      status = PHN_ERROR_OVERLAP;
    if (status == PHN_OK && !finite(x)) status = PHN_ERROR_NOT_FINITE;
  }
  if (status == PHN_OK) {
    double from[3];
    for (int k = 0; k < 3; ++k) from[k] = clamp(x[k], largest_place);
    const NearestPlace place = find(from);
    status = place.distance < 0 ? PHN_ERROR_UNDEFINED : PHN_OK;
    if (status == PHN_OK) found = place;
  }
  // The outputs may overlap x.
  for (int k = 0; k < 3 && point != nullptr; ++k) point[k] = found.point[k];
  if (distance != nullptr) *distance = found.is_inside ? -found.distance : found.distance;
  if (tool == nullptr) return status;
  *tool = {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}, {0, 0}};
  for (int k = 0; k < 3 && found.vertex[k] >= 0; ++k) {
    tool->nodes[k] = node_of(found.vertex[k]);
    tool->weights[k] = found.weight[k];
  }
  return status;
}

}  // namespace PHN_RUNTIME
