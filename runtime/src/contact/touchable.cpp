#include "contact/touchable.hpp"

#include <algorithm>

#include "tools/triangle.hpp"

namespace PHN_RUNTIME {
namespace {

bool is_touchable(const ContactSurface& s, const std::int32_t* vertex) {
  bool moves = false;
  const double* corner[3];
  for (int k = 0; k < 3; ++k) {
    const std::int32_t active = s.active[vertex[k]];
    if (active == -2) return false;
    moves = moves || active >= 0;
    corner[k] = row(s.rest, vertex[k]);
  }
  const Vector normal = area_normal(corner);
  return moves && dot(normal, normal) > 0;
}

/// Half the angle by the series of the arc sine of sin(angle / 2); the error is 0.3 % up to a right angle. The runtime
/// does not link an arc cosine.
double angle(double cosine) {
  const double square = std::fmax(0.0, (1 - cosine) / 2);
  return std::sqrt(square) * (1 + square * (1.0 / 6 + square * (3.0 / 40 + square * (15.0 / 336))));
}

void find_neighbors(TouchableEdge* edges, ContactSurface& s) {
  const std::int32_t n = 3 * s.n_triangles;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t* v = s.triangle + i / 3 * 3;
    const std::int32_t a = v[(i % 3 + 1) % 3], b = v[(i % 3 + 2) % 3];
    edges[i] = {a < b ? a : b, a < b ? b : a, i};
    s.neighbor[i] = -1;
  }
  const auto before = [](const TouchableEdge& a, const TouchableEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.corner < b.corner;
  };
  // Heap sort is fast enough at start-up and has a third of the code of std::sort.
  std::make_heap(edges, edges + n, before);
  std::sort_heap(edges, edges + n, before);
  const auto same = [&](std::int32_t i, std::int32_t j) {
    return j < n && edges[i].low == edges[j].low && edges[i].high == edges[j].high;
  };
  const auto first_of = [&](std::int32_t corner) { return s.triangle[corner / 3 * 3 + (corner % 3 + 1) % 3]; };
  for (std::int32_t i = 0, end; i < n; i = end) {
    for (end = i + 1; same(i, end);) ++end;
    const std::int32_t a = edges[i].corner, b = edges[end - 1].corner;
    // Neighbours are two triangles of consistent orientation. A tool does not slide across an edge of more triangles.
    if (end - i != 2 || first_of(a) == first_of(b)) continue;
    s.neighbor[a] = b / 3;
    s.neighbor[b] = a / 3;
  }
}

/// Mean normals, weighted by the angle at the vertex, with a length for which the planes around it move by 1 on
/// average.
void find_offsets(const std::int32_t* triangles, std::int32_t n, ContactSurface& s) {
  for (std::int32_t i = 0; i < 3 * s.n_vertices; ++i) s.offset[i] = 0;
  const auto each_corner = [&](const auto& visit) {
    for (std::int32_t t = 0; t < n; ++t) {
      const std::int32_t* vertex = triangles + 3 * static_cast<std::size_t>(t);
      const double* corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = row(s.rest, vertex[k]);
      Vector normal = area_normal(corner);
      const double area = norm(normal);
      if (!(area > 0)) continue;
      normal /= area;
      for (int k = 0; k < 3; ++k) {
        const Vector e = vector_at(corner[(k + 1) % 3]) - vector_at(corner[k]),
                     f = vector_at(corner[(k + 2) % 3]) - vector_at(corner[k]);
        visit(vertex[k], normal, angle(dot(e, f) / (norm(e) * norm(f))));
      }
    }
  };
  each_corner([&](std::int32_t v, const Vector& normal, double weight) {
    for (int k = 0; k < 3; ++k) row(s.offset, v)[k] += weight * normal[k];
  });
  for (std::int32_t v = 0; v < s.n_vertices; ++v) {
    double* m = row(s.offset, v);
    const double size = std::sqrt(dot(m, m));
    for (int k = 0; k < 3; ++k) m[k] = size > 1e-6 ? m[k] / size : 0;
  }
  // Temporary sums use memory that place() overwrites later.
  for (std::int32_t i = 0; i < 3 * s.n_vertices; ++i) s.placed[i] = 0;
  each_corner([&](std::int32_t v, const Vector& normal, double weight) {
    double *m = row(s.offset, v), *sums = row(s.placed, v);
    if (!(dot(m, m) > 0)) {
      for (int k = 0; k < 3; ++k) m[k] = normal[k];  // the normals cancel; use one of them
    }
    sums[0] += weight * dot(m, normal.x);
    sums[1] += weight;
  });
  for (std::int32_t v = 0; v < s.n_vertices; ++v) {
    const double* sums = row(s.placed, v);
    const double mitre = sums[0] > sums[1] / longest_offset ? sums[1] / sums[0] : longest_offset;
    for (int k = 0; k < 3; ++k) row(s.offset, v)[k] *= sums[1] > 0 ? mitre : 0;
  }
}

}  // namespace

ContactSurface lay_out_contact_surface(Arena& arena, std::int32_t n_vertices, std::int32_t n_field,
                                       std::int32_t n_triangles) {
  ContactSurface s = {};
  s.n_vertices = n_vertices;
  s.n_field = n_field;
  const auto vertices = static_cast<std::size_t>(s.n_vertices), triangles = static_cast<std::size_t>(n_triangles);
  s.triangle = arena.take<std::int32_t>(3 * triangles);
  s.neighbor = arena.take<std::int32_t>(3 * triangles);
  s.node = arena.take<std::int32_t>(vertices);
  s.active = arena.take<std::int32_t>(vertices);
  s.rest = arena.take<double>(3 * vertices);
  s.placed = arena.take<double>(3 * vertices);
  s.offset = arena.take<double>(3 * vertices);
  return s;
}

int build_contact_surface(const std::int32_t* triangles, std::int32_t n, TouchableEdge* scratch, ContactSurface& s) {
  double low[3], high[3];
  for (std::int32_t v = 0; v < s.n_vertices; ++v) {
    const double* x = row(s.rest, v);
    for (int k = 0; k < 3; ++k) {
      if (!(std::fabs(x[k]) <= largest_coordinate_m)) return PHN_ERROR_GEOMETRY;
      low[k] = v == 0 ? x[k] : std::fmin(low[k], x[k]);
      high[k] = v == 0 ? x[k] : std::fmax(high[k], x[k]);
    }
  }
  s.size = norm(vector_at(high) - vector_at(low));
  for (int k = 0; k < 3; ++k) s.middle[k] = (low[k] + high[k]) / 2;
  for (std::int32_t t = 0; t < n; ++t) {
    const std::int32_t* vertex = triangles + 3 * static_cast<std::size_t>(t);
    if (!is_touchable(s, vertex)) continue;
    for (int k = 0; k < 3; ++k) s.triangle[3 * s.n_triangles + k] = vertex[k];
    ++s.n_triangles;
  }
  if (s.n_triangles == 0) return PHN_ERROR_UNDEFINED;
  find_neighbors(scratch, s);
  find_offsets(triangles, n, s);
  place(nullptr, s);
  return PHN_OK;
}

double place(const double* field, ContactSurface& s) {
  const double largest = largest_distance * s.size;
  double most = 0;
  for (std::int32_t v = 0; v < s.n_vertices; ++v) {
    double moved[3];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t i = 3 * v + k;
      const double u = field != nullptr && v < s.n_field ? field[i] : 0;
      const double x = s.rest[i] + std::fmax(-largest, std::fmin(largest, u));
      moved[k] = x - s.placed[i];
      s.placed[i] = x;
    }
    most = std::fmax(most, dot(moved, moved));
  }
  return std::sqrt(most);
}

Vector point_at(const ContactSurface& s, const double* points, const SurfacePoint& point, double radius) {
  Vector x = {};
  for (int c = 0; c < 3; ++c) {
    const std::int32_t v = s.triangle[3 * point.triangle + c];
    x += point.weight[c] * (vector_at(row(points, v)) + radius * vector_at(row(s.offset, v)));
  }
  return x;
}

Vector normal_at(const ContactSurface& s, const SurfacePoint& point) {
  Vector normal = {};
  for (int c = 0; c < 3; ++c) normal += point.weight[c] * vector_at(row(s.offset, s.triangle[3 * point.triangle + c]));
  double size = norm(normal);
  if (!(size > 1e-6)) {
    const double* corner[3];
    corners_of(s, s.rest, point.triangle, corner);
    normal = area_normal(corner);
    size = norm(normal);
  }
  return normal / size;
}

SurfaceGradients gradients_at(const ContactSurface& s, const SurfacePoint& point) {
  const double* corner[3];
  corners_of(s, s.rest, point.triangle, corner);
  SurfaceGradients made = {};
  Vector gradient[3], normal, m = {};
  weight_gradients(corner, gradient, normal);
  const Vector edge = vector_at(corner[1]) - vector_at(corner[0]);
  made.axes[0] = edge / norm(edge);
  made.axes[1] = cross(normal, made.axes[0]);
  for (int c = 0; c < 3; ++c) {
    const Vector offset = vector_at(row(s.offset, s.triangle[3 * point.triangle + c]));
    m += point.weight[c] * offset;
    made.offset += outer(offset, gradient[c]);
  }
  const double size = norm(m);
  if (!(size > 1e-6)) return made;
  const Vector along = transposed_times(made.offset, m) / (size * size);
  made.normal = made.offset - outer(m, along);
  for (double& entry : made.normal.a) entry /= size;
  return made;
}

double movable_weight(const ContactSurface& s, const SurfacePoint& point) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += s.active[s.triangle[3 * point.triangle + c]] >= 0 ? point.weight[c] : 0;
  return sum;
}

}  // namespace PHN_RUNTIME
