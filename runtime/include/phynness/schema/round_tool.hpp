// The even pressure of a round tool on a surface (docs/decisions/round-tool.md), integrated in closed form. Bodies use
// it at run time, and meshes/ for the finite elements. No heap.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace phynness::schema {

/// A surface of triangles. The pointers refer to memory of the caller.
struct ToolSurface {
  const double* points;           ///< n_nodes x 3
  const double* normals;          ///< n_nodes x 3: unit normals of the nodes
  const std::int32_t* triangles;  ///< n_triangles x 3
  const std::int32_t* neighbors;  ///< n_triangles x 3: the triangle at the edge from corner k to k + 1; -1: none
  std::int32_t n_triangles;
};

/// Memory of a search, n_triangles of each.
struct ToolSearch {
  char* is_reached;       ///< zeros between searches
  std::int32_t* reached;  ///< the triangles under the tool
};

/// Finds the neighbors of all triangles. Of an edge of more than two triangles, two are joined. Of the triangles at a
/// node the first thousand are searched, which bounds the time for any text.
/// @param last_corner, previous_corner  working memory: n_nodes, 3 n_triangles
inline void find_neighbors(const std::int32_t* corner, std::int32_t n_triangles, std::int32_t n_nodes,
                           std::int32_t* last_corner, std::int32_t* previous_corner, std::int32_t* neighbors) {
  const std::int32_t n_corners = 3 * n_triangles;
  // The corners at each node are a linked list: its last corner, and for each corner the previous one.
  for (std::int32_t i = 0; i < n_nodes; ++i) last_corner[i] = -1;
  for (std::int32_t c = 0; c < n_corners; ++c) {
    neighbors[c] = -1;
    previous_corner[c] = last_corner[corner[c]];
    last_corner[corner[c]] = c;
  }
  const auto next = [](std::int32_t c) { return c % 3 == 2 ? c - 2 : c + 1; };
  for (std::int32_t c = 0; c < n_corners; ++c) {
    std::int32_t attempts = 1000;
    for (std::int32_t other = last_corner[corner[next(c)]]; other >= 0 && neighbors[c] < 0 && attempts > 0;
         other = previous_corner[other], --attempts)
      if (corner[next(other)] == corner[c]) neighbors[c] = other / 3;
  }
}

namespace round_tool {

struct Vector {
  double x[3];
};
inline Vector operator-(const Vector& a, const Vector& b) {
  return {{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};
}
inline Vector operator*(double factor, const Vector& a) {
  return {{a.x[0] * factor, a.x[1] * factor, a.x[2] * factor}};
}
inline Vector operator/(const Vector& a, double by) { return {{a.x[0] / by, a.x[1] / by, a.x[2] / by}}; }
inline double dot(const Vector& a, const Vector& b) { return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

/// Area, first and second moments, in a plane with the origin in the middle of a disc.
struct Moments {
  double area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

/// The angle from a to b of plane vectors, between -pi and pi. @param lengths  their product
inline double angle_between(const double* a, const double* b, double lengths) {
  const double across = a[0] * b[1] - a[1] * b[0], along = a[0] * b[0] + a[1] * b[1];
  if (!(lengths + along > 1e-15 * lengths)) return across < 0 ? -3.14159265358979323846 : 3.14159265358979323846;
  double t = across / (lengths + along);  // of half the angle; halved until atan(t) is its series
  int doublings = 1;
  for (; t > 0.1 || t < -0.1; ++doublings) t /= 1 + std::sqrt(1 + t * t);
  double sum = 0;
  for (int k = 15; k >= 1; k -= 2) sum = 1.0 / k - t * t * sum;
  for (sum *= t; doublings > 0; --doublings) sum *= 2;
  return sum;
}

inline void add_sector(double radius, const double* a, const double* b, Moments& sum) {
  const double length_a = std::sqrt(a[0] * a[0] + a[1] * a[1]), length_b = std::sqrt(b[0] * b[0] + b[1] * b[1]);
  if (!(length_a > 0 && length_b > 0)) return;
  const double angle = angle_between(a, b, length_a * length_b);
  const double third = radius * radius * radius / 3, eighth = radius * radius * radius * radius / 8;
  sum.area += radius * radius * angle / 2;
  sum.x += third * (b[1] / length_b - a[1] / length_a);
  sum.y += third * (a[0] / length_a - b[0] / length_b);
  const double a_a = length_a * length_a, b_b = length_b * length_b, turn = b[0] * b[1] / b_b - a[0] * a[1] / a_a;
  sum.xx += eighth * (angle + turn);
  sum.yy += eighth * (angle - turn);
  sum.xy += eighth * (b[1] * b[1] / b_b - a[1] * a[1] / a_a);
}

/// The triangle of the middle, a and b.
inline void add_triangle(const double* a, const double* b, Moments& sum) {
  const double area = (a[0] * b[1] - a[1] * b[0]) / 2, x = a[0] + b[0], y = a[1] + b[1];
  sum.area += area;
  sum.x += area * x / 3;
  sum.y += area * y / 3;
  sum.xx += area * (a[0] * a[0] + b[0] * b[0] + x * x) / 12;
  sum.yy += area * (a[1] * a[1] + b[1] * b[1] + y * y) / 12;
  sum.xy += area * (a[0] * a[1] + b[0] * b[1] + x * y) / 12;
}

/// Adds the part of the disc in the triangle of its middle, a and b, with the sign of their order. The sum over the
/// edges of a polygon is the part of the disc inside.
inline void add_edge(double radius, const double* a, const double* b, Moments& sum) {
  const double d[2] = {b[0] - a[0], b[1] - a[1]};
  const double dd = d[0] * d[0] + d[1] * d[1], ad = a[0] * d[0] + a[1] * d[1];
  const double root = ad * ad - dd * (a[0] * a[0] + a[1] * a[1] - radius * radius);
  double from = 1, to = 1;  // the edge is inside of the disc between these
  if (dd > 0 && root > 0) {
    from = std::fmin(std::fmax((-ad - std::sqrt(root)) / dd, 0), 1);
    to = std::fmin(std::fmax((-ad + std::sqrt(root)) / dd, 0), 1);
  }
  const double p[2] = {a[0] + from * d[0], a[1] + from * d[1]}, q[2] = {a[0] + to * d[0], a[1] + to * d[1]};
  if (from > 0) add_sector(radius, a, p, sum);
  if (to > from) add_triangle(p, q, sum);
  if (to < 1) add_sector(radius, q, b, sum);
}

/// The squared distance from x to the edge from a to b.
inline double distance2_to_edge(const Vector& x, const Vector& a, const Vector& b) {
  const Vector along = b - a;
  const double square = dot(along, along);
  const double t = square > 0 ? std::fmin(std::fmax(dot(x - a, along) / square, 0), 1) : 0;
  const Vector apart = x - a - t * along;
  return dot(apart, apart);
}

/// Integrals over the part of a triangle within the radius around x: of the linear functions of its corners, and in six
/// numbers of its quadratic functions, of the corners and then of the edges from corner k to k + 1.
template <int n_functions>
void integrate(const Vector (&corner)[3], const Vector& x, double radius, const Vector& normal,
               double (&out)[n_functions]) {
  static_assert(n_functions == 3 || n_functions == 6);
  const double height = dot(x - corner[0], normal), squared = radius * radius - height * height;
  for (double& value : out) value = 0;
  if (!(squared > 0)) return;
  const Vector edge = corner[1] - corner[0], e1 = edge / std::sqrt(dot(edge, edge)), e2 = cross(normal, e1);
  double at[3][2];
  for (int k = 0; k < 3; ++k) {
    const Vector from_middle = corner[k] - x;
    at[k][0] = dot(from_middle, e1);
    at[k][1] = dot(from_middle, e2);
  }
  Moments sum;
  for (int k = 0; k < 3; ++k) add_edge(std::sqrt(squared), at[k], at[(k + 1) % 3], sum);
  if (!(sum.area > 0)) return;
  const double twice = (at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) - (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]);
  for (int k = 0; k < 3; ++k) {  // the function of corner k is cross(p - i, j - i) / twice, i and j the other corners
    const double *i = at[(k + 1) % 3], *j = at[(k + 2) % 3];
    out[k] =
        std::fmax(((sum.x - sum.area * i[0]) * (i[1] - j[1]) + (sum.y - sum.area * i[1]) * (j[0] - i[0])) / twice, 0);
  }
  if constexpr (n_functions == 6) {
    double c[3][3];  // the linear functions c0 + c1 x + c2 y
    for (int k = 0; k < 3; ++k) {
      const double *i = at[(k + 1) % 3], *j = at[(k + 2) % 3];
      c[k][1] = (i[1] - j[1]) / twice;
      c[k][2] = (j[0] - i[0]) / twice;
      c[k][0] = -(c[k][1] * i[0] + c[k][2] * i[1]);
    }
    const auto product = [&](const double* a, const double* b) {
      return a[0] * b[0] * sum.area + (a[0] * b[1] + a[1] * b[0]) * sum.x + (a[0] * b[2] + a[2] * b[0]) * sum.y +
             a[1] * b[1] * sum.xx + (a[1] * b[2] + a[2] * b[1]) * sum.xy + a[2] * b[2] * sum.yy;
    };
    for (int k = 0; k < 3; ++k) {
      out[k] = 2 * product(c[k], c[k]) - out[k];
      out[3 + k] = 4 * product(c[k], c[(k + 1) % 3]);
    }
  }
}

}  // namespace round_tool

/// Divisor of the integrals of linear functions with the pressure, which makes them weights of a round tool: their sum
/// over points that move, and a part of the sum over fixed points of triangles of which a point moves. The surface
/// rises there from the fixed points faster than linear functions, the more so, the more of the tool is beside them
/// (docs/decisions/element.md). The weights have at least the sum 3/5.
/// @param moving, fixed  these two sums; moving > 0
inline double weight_divisor(double moving, double fixed) { return moving + moving * fixed / (moving + 1.5 * fixed); }

/// The part of `fixed` from one triangle. @param is_fixed  of its corners: is_fixed(k)
template <class IsFixed>
double integrals_at_fixed(const double* integrals, const IsFixed& is_fixed) {
  double sum = 0;
  bool moves = false;
  for (int k = 0; k < 3; ++k)
    if (is_fixed(k))
      sum += integrals[k];
    else
      moves = true;
  return moves ? sum : 0;
}

/// Calls take(triangle, integrals) for the triangles under a round tool: those that are connected to its middle over
/// edges within its radius (straight distance). The integrals, of n_functions as in round_tool::integrate, have the
/// factor max(0, n . n_0) of the normals there and at the middle (docs/decisions/round-tool.md), so that a tool wider
/// than the body is thick does not press the far side, and around a rim the pressure fades. They are not normalized.
/// @param corner, share  of the middle: up to three nodes of a triangle, and their weights, > 0 where they count
/// @pre radius > 0
template <int n_functions, class Take>
void integrate_pressure(const ToolSurface& surface, const ToolSearch& search, const std::int32_t* corner,
                        const double* share, double radius, const Take& take) {
  using round_tool::Vector;
  const auto at = [](const double* rows, std::int32_t i) {
    const double* x = rows + 3 * static_cast<std::size_t>(i);
    return Vector{{x[0], x[1], x[2]}};
  };
  const auto corners_of = [&](std::int32_t t) { return surface.triangles + 3 * static_cast<std::size_t>(t); };
  std::int32_t n_reached = 0;
  const auto reach = [&](std::int32_t t) {
    if (search.is_reached[t]) return;
    search.is_reached[t] = 1;
    search.reached[n_reached++] = t;
  };
  // The normal between nodes is the mean of their normals, so that it is continuous over edges of the body.
  Vector middle = {}, normal = {};
  for (int k = 0; k < 3; ++k) {
    if (!(share[k] > 0)) continue;
    const Vector x = at(surface.points, corner[k]), n = at(surface.normals, corner[k]);
    for (int i = 0; i < 3; ++i) {
      middle.x[i] += share[k] * x.x[i];
      normal.x[i] += share[k] * n.x[i];
    }
  }
  normal = normal / std::fmax(std::sqrt(dot(normal, normal)), 1e-300);
  for (std::int32_t t = 0; t < surface.n_triangles; ++t) {
    const std::int32_t* c = corners_of(t);
    bool has_all = true;
    for (int k = 0; k < 3; ++k)
      has_all = has_all && (!(share[k] > 0) || c[0] == corner[k] || c[1] == corner[k] || c[2] == corner[k]);
    if (has_all) reach(t);
  }
  for (std::int32_t n = 0; n < n_reached; ++n) {
    const std::int32_t t = search.reached[n];
    Vector x[3];
    for (int k = 0; k < 3; ++k) x[k] = at(surface.points, corners_of(t)[k]);
    const Vector area = cross(x[1] - x[0], x[2] - x[0]);
    const double size = std::sqrt(dot(area, area)), facing = dot(normal, area) / size;
    if (facing > 0) {
      double integrals[n_functions];
      round_tool::integrate(x, middle, radius, area / size, integrals);
      for (double& value : integrals) value *= facing;
      take(t, integrals);
    }
    for (int k = 0; k < 3; ++k) {
      const std::int32_t other = surface.neighbors[3 * static_cast<std::size_t>(t) + static_cast<std::size_t>(k)];
      if (other >= 0 && round_tool::distance2_to_edge(middle, x[k], x[(k + 1) % 3]) < radius * radius) reach(other);
    }
  }
  for (std::int32_t n = 0; n < n_reached; ++n) search.is_reached[search.reached[n]] = 0;
}

}  // namespace phynness::schema
