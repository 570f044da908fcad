#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "fine_surface.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// The scheme as the literature states it, with maps and without any thought of time. Edges with one triangle
/// or more than two are creases; vertices on two creases follow them, on more they stay.
struct NaiveSurface {
  std::vector<RowVector3d> values;
  std::vector<Corners> triangles;

  void subdivide() {
    std::map<std::pair<int, int>, std::vector<int>> opposite;
    std::map<int, std::set<int>> neighbors, along_creases;
    for (const Corners& t : triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3];
        opposite[std::minmax(a, b)].push_back(t[(k + 2) % 3]);
        neighbors[a].insert(b);
        neighbors[b].insert(a);
      }
    for (const auto& [edge, others] : opposite) {
      if (others.size() == 2) continue;
      along_creases[edge.first].insert(edge.second);
      along_creases[edge.second].insert(edge.first);
    }
    const auto at = [&](int v) { return values[static_cast<std::size_t>(v)]; };
    std::vector<RowVector3d> finer;
    for (int v = 0; v < static_cast<int>(values.size()); ++v) {
      const auto& creases = along_creases[v];
      RowVector3d moved = at(v);
      if (creases.size() == 2) {
        moved = 0.75 * at(v) + 0.125 * (at(*creases.begin()) + at(*creases.rbegin()));
      } else if (creases.size() < 2 && !neighbors[v].empty()) {
        const auto n = static_cast<double>(neighbors[v].size());
        const double beta = (5.0 / 8 - std::pow(3.0 / 8 + std::cos(2 * std::numbers::pi / n) / 4, 2)) / n;
        moved *= 1 - n * beta;
        for (const int w : neighbors[v]) moved += beta * at(w);
      }
      finer.push_back(moved);
    }
    std::map<std::pair<int, int>, int> middle;
    for (const auto& [edge, others] : opposite) {
      middle[edge] = static_cast<int>(finer.size());
      finer.push_back(others.size() == 2 ? RowVector3d(3.0 / 8 * (at(edge.first) + at(edge.second)) +
                                                       1.0 / 8 * (at(others[0]) + at(others[1])))
                                         : RowVector3d((at(edge.first) + at(edge.second)) / 2));
    }
    std::vector<Corners> children;
    for (const auto& [a, b, c] : triangles) {
      const int ab = middle[std::minmax(a, b)], bc = middle[std::minmax(b, c)], ca = middle[std::minmax(c, a)];
      for (const Corners& child : {Corners{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
        children.push_back(child);
    }
    values = std::move(finer);
    triangles = std::move(children);
  }
};

Points random_field(const Body& body) {
  Numbers numbers;
  Points field(body.n_output(), 3);
  for (Eigen::Index i = 0; i < field.size(); ++i) field.data()[i] = numbers.next();
  return field;
}

/// A few roundings of floats for each level, of values up to 1.
constexpr double subdivision_rounding = 2e-6;

// Claim: on every surface, manifold or not, points and fields are those of the plain scheme, corner by corner
// of the triangles, whose order is the same.
TEST(Surfaces, AreThoseOfThePlainScheme) {
  for (const Body& body : bodies()) {
    const Points field = random_field(body);
    NaiveSurface points{body.points, body.triangles}, moved{body.points, body.triangles};
    for (int i = 0; i < static_cast<int>(body.points.size()); ++i)
      moved.values[static_cast<std::size_t>(i)] =
          i < body.n_output() ? RowVector3d(field.row(i)) : RowVector3d(0, 0, 0);
    for (int levels = 0; levels <= 4; ++levels) {
      FineSurface fine(body, levels);
      ASSERT_EQ(fine.n_vertices, static_cast<int>(points.values.size()));
      ASSERT_EQ(fine.n_triangles, static_cast<int>(points.triangles.size()));
      const Points u = fine.deform(field);
      for (int t = 0; t < fine.n_triangles; ++t)
        for (int k = 0; k < 3; ++k) {
          const auto naive =
              static_cast<std::size_t>(points.triangles[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)]);
          ASSERT_LE((fine.point(fine.corner(t, k)) - points.values[naive]).norm(), 5 * subdivision_rounding);
          ASSERT_LE((u.row(fine.corner(t, k)) - moved.values[naive]).norm(), subdivision_rounding);
        }
      // Vertices of level 0 keep their numbers, those without triangles, too.
      for (std::size_t i = 0; i < body.points.size(); ++i)
        ASSERT_LE((u.row(static_cast<Eigen::Index>(i)) - moved.values[i]).norm(), subdivision_rounding);
      points.subdivide();
      moved.subdivide();
    }
  }
}

}  // namespace
