#include "contact/touchable.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr int most_crossings = 32;

/// Removes rounding errors of the weights, which are then >= 0 with the sum 1, and keeps a distance from fixed edges.
void normalize(const ContactSurface& s, SurfacePoint& point) {
  double sum = 0;
  for (double& w : point.weight) sum += w = w > 0 ? w : 0;
  for (double& w : point.weight) w = sum > 0 ? w / sum : 1.0 / 3;
  bool moves[3];
  for (int c = 0; c < 3; ++c) moves[c] = s.active[s.triangle[3 * point.triangle + c]] >= 0;
  raise_movable_weight(moves, 3, movable_weight(s, point), point.weight);
}

/// Moves the point to the triangle across the edge opposite to corner `opposite` and turns the step into its plane.
void cross_edge(const ContactSurface& s, SurfacePoint& point, int opposite, const Vector& normal, Vector& step) {
  const std::int32_t next = s.neighbor[3 * point.triangle + opposite];
  const std::int32_t *from = s.triangle + 3 * point.triangle, *to = s.triangle + 3 * next;
  SurfacePoint next_point = {next, {0, 0, 0}};
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      if (c != opposite && to[d] == from[c]) next_point.weight[d] = point.weight[c];
  const double* corner[3];
  Vector edge = vector_at(row(s.rest, from[(opposite + 2) % 3])) - vector_at(row(s.rest, from[(opposite + 1) % 3]));
  corners_of(s, s.rest, next, corner);
  Vector next_normal = area_normal(corner);
  edge /= norm(edge);
  next_normal /= norm(next_normal);
  // The two triangles traverse their common edge in opposite directions.
  const Vector out = cross(edge, normal), in = cross(edge, next_normal);
  step = dot(step, edge) * edge + dot(step, out) * in;
  point = next_point;
}

}  // namespace

void walk(const ContactSurface& s, SurfacePoint& point, const Vector& step) {
  Vector remaining = step;
  for (int crossing = 0; crossing < most_crossings; ++crossing) {
    const double* corner[3];
    corners_of(s, s.rest, point.triangle, corner);
    double change[3], most = 0;
    Vector normal, gradient[3];
    weight_gradients(corner, gradient, normal);
    for (int c = 0; c < 3; ++c) {
      change[c] = dot(gradient[c], remaining);
      most = std::fmax(most, std::fabs(change[c]));
    }
    double part = 1;
    int crossed = -1;
    for (int c = 0; c < 3; ++c) {
      if (!(change[c] < -1e-12 * most) || point.weight[c] + part * change[c] >= 0) continue;
      part = std::fmax(0.0, point.weight[c] / -change[c]);
      crossed = c;
    }
    for (int c = 0; c < 3; ++c) point.weight[c] += part * change[c];
    if (crossed < 0) break;
    point.weight[crossed] = 0;
    remaining *= 1 - part;
    if (s.neighbor[3 * point.triangle + crossed] >= 0) {
      cross_edge(s, point, crossed, normal, remaining);
      continue;
    }
    const Vector edge = vector_at(corner[(crossed + 2) % 3]) - vector_at(corner[(crossed + 1) % 3]);
    remaining = dot(remaining, edge) / dot(edge, edge) * edge;
  }
  normalize(s, point);
}

}  // namespace PHN_RUNTIME
