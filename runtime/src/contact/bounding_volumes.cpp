#include "contact/bounding_volumes.hpp"

#include <algorithm>

#include "tools/triangle.hpp"

namespace PHN_RUNTIME {
namespace {

constexpr std::int32_t largest_leaf = 4;
constexpr int deepest = 64;  // halving 2^31 triangles gives a depth of 31

// These replace fmin and fmax, which compilers do not inline because of their rules for NaN. The calls took half of the
// time.
double lesser(double a, double b) { return a < b ? a : b; }
double greater(double a, double b) { return a > b ? a : b; }

std::int32_t build(const ContactSurface& s, BoundingVolumes& v, std::int32_t first, std::int32_t count) {
  const std::int32_t node = v.n_volumes++;
  v.volume[node].right = -1;
  v.volume[node].first = first;
  v.volume[node].count = count;
  if (count <= largest_leaf) return node;
  const auto middle = [&](std::int32_t triangle, int k) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += s.rest[3 * static_cast<std::size_t>(s.triangle[3 * triangle + c]) + k];
    return sum;
  };
  int axis = 0;
  double longest = -1;
  for (int k = 0; k < 3; ++k) {
    double low = middle(v.order[first], k), high = low;
    for (std::int32_t i = first; i < first + count; ++i) {
      low = lesser(low, middle(v.order[i], k));
      high = greater(high, middle(v.order[i], k));
    }
    if (high - low > longest) {
      longest = high - low;
      axis = k;
    }
  }
  const std::int32_t half = count / 2;
  std::nth_element(v.order + first, v.order + first + half, v.order + first + count,
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = middle(a, axis), y = middle(b, axis);
                     return x != y ? x < y : a < b;
                   });
  build(s, v, first, half);
  v.volume[node].right = build(s, v, first + half, count - half);
  return node;
}

void corners_of(const ContactSurface& s, std::int32_t triangle, double radius, double corner[3][3]) {
  for (int c = 0; c < 3; ++c) {
    const std::size_t row = 3 * static_cast<std::size_t>(s.triangle[3 * triangle + c]);
    for (int k = 0; k < 3; ++k) corner[c][k] = s.placed[row + k] + radius * s.offset[row + k];
  }
}

/// The segment from + t (to - from), t in 0 ... 1.
struct Segment {
  Vector from, along;
  double slack;
};

/// Position on the segment, 0 ... 1, at which it enters the box; > 1: it does not enter.
double entry_position(const BoundingVolume& v, double radius, const Segment& segment) {
  double enters = 0, leaves = 1;
  for (int k = 0; k < 3; ++k) {
    const double low = v.low[k] + radius * v.offset_low[k] - segment.slack - segment.from[k],
                 high = v.high[k] + radius * v.offset_high[k] + segment.slack - segment.from[k], d = segment.along[k];
    if (std::fabs(d) <= segment.slack) {
      if (low > greater(d, 0.0) || high < lesser(d, 0.0)) return 2;
      continue;
    }
    const double a = low / d, b = high / d;
    enters = greater(enters, lesser(a, b));
    leaves = lesser(leaves, greater(a, b));
  }
  return enters <= leaves ? enters : 2;
}

/// Position on the segment at which it crosses a triangle, or -1, by signed volumes of the segment and the three edges.
/// Two triangles compute the same number, up to its sign, for a common edge, so that no segment passes between them.
double crossing_position(const double corner[3][3], const Segment& segment, double* weight) {
  Vector x[3];
  double volume[3], sum = 0;
  for (int c = 0; c < 3; ++c) x[c] = vector_at(corner[c]) - segment.from;
  const Vector normal = cross(x[1] - x[0], x[2] - x[0]);
  const double size = norm(normal);
  if (!(size > 0)) return -1;
  const double before = -dot(normal, x[0]) / size, after = before + dot(normal, segment.along) / size;
  if (!(after < 0 && before >= -segment.slack && after < before)) return -1;
  for (int c = 0; c < 3; ++c) {
    volume[c] = -dot(segment.along, cross(x[(c + 1) % 3], x[(c + 2) % 3]));
    if (volume[c] < 0) return -1;
    sum += volume[c];
  }
  if (!(sum > 0)) return -1;
  for (int c = 0; c < 3; ++c) weight[c] = volume[c] / sum;
  return greater(0.0, before / (before - after));
}

double square_distance(const BoundingVolume& v, double radius, const double* x) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double low = v.low[k] + radius * v.offset_low[k], high = v.high[k] + radius * v.offset_high[k];
    const double difference = greater(0.0, greater(low - x[k], x[k] - high));
    sum += difference * difference;
  }
  return sum;
}

}  // namespace

BoundingVolumes lay_out_volumes(Arena& arena, std::int32_t n_triangles) {
  BoundingVolumes v = {};
  // This is enough, because every leaf has at least two triangles unless there is only one triangle.
  v.volume = arena.take<BoundingVolume>(static_cast<std::size_t>(n_triangles));
  v.order = arena.take<std::int32_t>(static_cast<std::size_t>(n_triangles));
  return v;
}

void build_volumes(const ContactSurface& s, BoundingVolumes& v) {
  for (std::int32_t i = 0; i < s.n_triangles; ++i) v.order[i] = i;
  v.n_volumes = 0;
  build(s, v, 0, s.n_triangles);
  refit_volumes(s, v);
}

void refit_volumes(const ContactSurface& s, BoundingVolumes& v) {
  for (std::int32_t i = v.n_volumes - 1; i >= 0; --i) {
    BoundingVolume& box = v.volume[i];
    const auto enclose = [&](bool first, const double* low, const double* high, const double* offset_low,
                             const double* offset_high) {
      for (int k = 0; k < 3; ++k) {
        box.low[k] = first ? low[k] : lesser(box.low[k], low[k]);
        box.high[k] = first ? high[k] : greater(box.high[k], high[k]);
        box.offset_low[k] = first ? offset_low[k] : lesser(box.offset_low[k], offset_low[k]);
        box.offset_high[k] = first ? offset_high[k] : greater(box.offset_high[k], offset_high[k]);
      }
    };
    if (box.right >= 0) {
      const BoundingVolume &left = v.volume[i + 1], &right = v.volume[box.right];
      enclose(true, left.low, left.high, left.offset_low, left.offset_high);
      enclose(false, right.low, right.high, right.offset_low, right.offset_high);
      continue;
    }
    for (std::int32_t j = 0; j < 3 * box.count; ++j) {
      const std::int32_t triangle = v.order[box.first + j / 3];
      const std::size_t row = 3 * static_cast<std::size_t>(s.triangle[3 * triangle + j % 3]);
      enclose(j == 0, s.placed + row, s.placed + row, s.offset + row, s.offset + row);
    }
  }
}

double sweep(const ContactSurface& s, const BoundingVolumes& v, double radius, const double* from, const double* to,
             double slack, SurfacePoint& point) {
  const Segment segment = {vector_at(from), vector_at(to) - vector_at(from), slack};
  double first = 2;
  std::int32_t stack[deepest];
  int n = 0;
  stack[n++] = 0;
  while (n > 0) {
    const std::int32_t i = stack[--n];
    const BoundingVolume& box = v.volume[i];
    if (entry_position(box, radius, segment) > lesser(first, 1.0)) continue;
    if (box.right >= 0) {
      stack[n++] = box.right;
      stack[n++] = i + 1;
      continue;
    }
    for (std::int32_t j = box.first; j < box.first + box.count; ++j) {
      double corner[3][3], weight[3];
      corners_of(s, v.order[j], radius, corner);
      const double part = crossing_position(corner, segment, weight);
      if (part < 0 || part >= first) continue;
      const SurfacePoint hit = {v.order[j], {weight[0], weight[1], weight[2]}};
      if (movable_weight(s, hit) < smallest_movable_weight<double>) continue;
      first = part;
      point = hit;
    }
  }
  return first <= 1 ? first : -1;
}

double nearest(const ContactSurface& s, const BoundingVolumes& v, double radius, const double* x, SurfacePoint& point) {
  double least = -1;
  std::int32_t stack[deepest];
  int n = 0;
  stack[n++] = 0;
  point = {0, {1, 0, 0}};
  while (n > 0) {
    const std::int32_t i = stack[--n];
    const BoundingVolume& box = v.volume[i];
    if (least >= 0 && square_distance(box, radius, x) > least * least) continue;
    if (box.right >= 0) {
      const bool left_first =
          square_distance(v.volume[i + 1], radius, x) <= square_distance(v.volume[box.right], radius, x);
      stack[n++] = left_first ? box.right : i + 1;
      stack[n++] = left_first ? i + 1 : box.right;
      continue;
    }
    for (std::int32_t j = box.first; j < box.first + box.count; ++j) {
      double corner[3][3], weight[3], nearest_point[3], distance = 0;
      corners_of(s, v.order[j], radius, corner);
      const double* const corners[3] = {corner[0], corner[1], corner[2]};
      nearest_on_triangle(corners, x, weight, nearest_point, distance);
      if (least >= 0 && distance >= least) continue;
      least = distance;
      point = {v.order[j], {weight[0], weight[1], weight[2]}};
    }
  }
  return least;
}

}  // namespace PHN_RUNTIME
