// Neighbours of the probed points of a surface, and gradients of functions of the place from the values there (equation
// (x) of docs/theory.md). The runtime and images use it. No heap.
#pragma once

#include <cmath>
#include <cstdint>
#include <phynness/schema/bounds.hpp>

namespace phynness::schema {

/// The nearest neighbours of a point, ascending.
struct NearPoints {
  std::int32_t n;
  std::int32_t point[most_neighbours];
};

/// With the gradient of a function E of the place: sum_i slope_i (E_i - E).
struct Neighbours : NearPoints {
  double slope[most_neighbours][3];  ///< [1/m]
};

inline double apart(const double* a, const double* b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

/// Adds a neighbour if it is one of the nearest. @param most  largest number @param point_of  coordinates of a point
template <class PointOf>
void keep_near(std::int32_t own, std::int32_t other, std::int32_t most, const PointOf& point_of, NearPoints& kept) {
  constexpr double tie = 1 - 1e-9;  // Rounding does not decide between points that are equally near.
  if (own == other) return;
  for (std::int32_t i = 0; i < kept.n; ++i)
    if (kept.point[i] == other) return;
  const double distance = apart(point_of(own), point_of(other));
  std::int32_t at = kept.n;
  while (at > 0 && distance < tie * apart(point_of(own), point_of(kept.point[at - 1]))) --at;
  if (at == most) return;
  if (kept.n < most) ++kept.n;
  for (std::int32_t i = kept.n - 1; i > at; --i) kept.point[i] = kept.point[i - 1];
  kept.point[at] = other;
}

/// Sets the slopes of (x): the gradient of a sum of Wendland's functions through the differences to the neighbours.
template <class PointOf>
void set_slopes(std::int32_t own, const PointOf& point_of, Neighbours& near) {
  constexpr double radius = 20;       // of the functions, in root mean square distances of the neighbours
  constexpr double smoothing = 5e-5;  // Neighbours beside each other share their weight.
  constexpr double none[3] = {0, 0, 0};
  const auto function = [](double r) { return (1 - r) * (1 - r) * (1 - r) * (1 - r) * (1 + 4 * r); };
  const std::int32_t n = near.n;
  double edge[most_neighbours][3], system[most_neighbours][most_neighbours + 3], squares = 0;
  for (std::int32_t i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) {
      edge[i][k] = point_of(near.point[i])[k] - point_of(own)[k];
      squares += edge[i][k] * edge[i][k];
      near.slope[i][k] = 0;
    }
  if (!(squares > 0)) return;
  const double unit = radius * std::sqrt(squares / n);
  for (std::int32_t i = 0; i < n; ++i)
    for (double& x : edge[i]) x /= unit;
  for (std::int32_t i = 0; i < n; ++i) {
    const double r = apart(edge[i], none);
    for (std::int32_t j = 0; j < n; ++j)
      system[i][j] = function(apart(edge[i], edge[j])) - function(r) - function(apart(edge[j], none)) + 1;
    system[i][i] += smoothing;
    for (int k = 0; k < 3; ++k) system[i][n + k] = 20 * (1 - r) * (1 - r) * (1 - r) * edge[i][k] / unit;
  }
  // Gauss-Jordan elimination. The matrix is positive definite.
  for (std::int32_t k = 0; k < n; ++k)
    for (std::int32_t i = 0; i < n; ++i) {
      const double factor = i == k ? 0 : system[i][k] / system[k][k];
      for (std::int32_t j = k; j < n + 3; ++j) system[i][j] -= factor * system[k][j];
    }
  for (std::int32_t i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) near.slope[i][k] = system[i][n + k] / system[i][i];
}

/// Finds the nearest neighbours of each point in triangles and sets the slopes. A point that has few, as at a border,
/// has those of its neighbours, too.
/// @param corner_of  point of corner k of triangle t; -1: none
/// @param first      working memory: n_points
/// @param neighbours n_points
template <class PointOf, class CornerOf>
void find_neighbours(std::int32_t n_points, const PointOf& point_of, std::int32_t n_triangles,
                     const CornerOf& corner_of, NearPoints* first, Neighbours* neighbours) {
  for (std::int32_t i = 0; i < n_points; ++i) first[i].n = 0;
  for (std::int32_t t = 0; t < n_triangles; ++t) {
    const std::int32_t corner[3] = {corner_of(t, 0), corner_of(t, 1), corner_of(t, 2)};
    for (int k = 0; k < 9; ++k) {
      const std::int32_t own = corner[k / 3], other = corner[k % 3];
      if (own >= 0 && other >= 0) keep_near(own, other, most_neighbours, point_of, first[own]);
    }
  }
  for (std::int32_t own = 0; own < n_points; ++own) {
    Neighbours& near = neighbours[own];
    static_cast<NearPoints&>(near) = first[own];
    for (std::int32_t i = 0; i < first[own].n && first[own].n < enough_neighbours; ++i) {
      const NearPoints& next = first[first[own].point[i]];
      for (std::int32_t j = 0; j < next.n; ++j) keep_near(own, next.point[j], enough_neighbours, point_of, near);
    }
    set_slopes(own, point_of, near);
  }
}

}  // namespace phynness::schema
