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
    for (const Corners& t : triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3];
        opposite[std::minmax(a, b)].push_back(t[(k + 2) % 3]);
        neighbors[a].insert(b);
        neighbors[b].insert(a);
      }
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

/// As many vertices as the paper's liver: 27 rings of 22 between two poles, the last 110 fixed.
Body liver_sized() {
  constexpr int n_rings = 27, n = 22;
  Body body;
  body.n_fixed = 110;
  body.points.push_back({0, 0, 0.04});
  for (int r = 1; r <= n_rings; ++r) {
    for (int i = 0; i < n; ++i) {
      const double polar = std::numbers::pi * r / (n_rings + 1), turn = 2 * std::numbers::pi * i / n;
      body.points.push_back(
          {0.10 * std::sin(polar) * std::cos(turn), 0.07 * std::sin(polar) * std::sin(turn), 0.04 * std::cos(polar)});
    }
  }
  body.points.push_back({0, 0, -0.04});
  const auto at = [&](int ring, int i) { return 1 + ring * n + i % n; };
  for (int i = 0; i < n; ++i) {
    body.triangles.push_back({0, at(0, i), at(0, i + 1)});
    body.triangles.push_back({n_rings * n + 1, at(n_rings - 1, i + 1), at(n_rings - 1, i)});
    for (int r = 0; r + 1 < n_rings; ++r) {
      body.triangles.push_back({at(r, i), at(r + 1, i), at(r + 1, i + 1)});
      body.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r, i + 1)});
    }
  }
  return body;
}

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
      for (int t = 0; t < fine.n_triangles; ++t) {
        for (int k = 0; k < 3; ++k) {
          const auto naive =
              static_cast<std::size_t>(points.triangles[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)]);
          ASSERT_LE((fine.point(fine.corner(t, k)) - points.values[naive]).norm(), 5 * subdivision_rounding);
          ASSERT_LE((u.row(fine.corner(t, k)) - moved.values[naive]).norm(), subdivision_rounding);
        }
      }
      // Vertices of level 0 keep their numbers, those without triangles, too.
      for (std::size_t i = 0; i < body.points.size(); ++i)
        ASSERT_LE((u.row(static_cast<Eigen::Index>(i)) - moved.values[i]).norm(), subdivision_rounding);
      points.subdivide();
      moved.subdivide();
    }
  }
}

// Claim: the paper's four levels: 596, 2,378, 9,506 and 38,018 vertices of a closed surface, four times the
// triangles each. It stays closed and oriented: every directed edge occurs once, and its reverse.
TEST(Surfaces, HaveThePapersCounts) {
  const int expected[] = {596, 2378, 9506, 38018};
  for (int levels = 0; levels < 4; ++levels) {
    const FineSurface fine(liver_sized(), levels);
    EXPECT_EQ(fine.n_vertices, expected[levels]);
    EXPECT_EQ(fine.n_triangles, 1188 << (2 * levels));
    std::set<std::pair<int, int>> directed;
    for (int t = 0; t < fine.n_triangles; ++t) {
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(directed.insert({fine.corner(t, k), fine.corner(t, (k + 1) % 3)}).second);
    }
    for (const auto& [a, b] : directed) ASSERT_TRUE(directed.count({b, a}));
  }
}

// Claim: weights add up to 1: what moves every vertex by an affine map of its place moves every fine vertex
// by the same map of its own; a constant stays constant. To rounding of floats: values reach 4.
TEST(Surfaces, CommuteWithAffineMaps) {
  Eigen::Matrix3d map;
  map << 0.5, -1, 0.3, 0.2, 0.1, -0.7, 1.1, 0, 0.4;
  const RowVector3d shift(0.3, -0.2, 1);
  for (Body body : bodies()) {
    body.n_fixed = 0;  // they would not follow
    for (const bool constant : {true, false}) {
      FineSurface fine(body, 4);
      Points field(body.n_output(), 3);
      const auto image = [&](const RowVector3d& x) { return constant ? shift : RowVector3d(x * map + shift); };
      for (int i = 0; i < body.n_output(); ++i) field.row(i) = image(body.points[static_cast<std::size_t>(i)]);
      const Points u = fine.deform(field);
      for (int v = 0; v < fine.n_vertices; ++v)
        ASSERT_LE((u.row(v) - image(fine.point(v))).norm(), (constant ? 1 : 10) * subdivision_rounding);
    }
  }
}

// Claim: where all vertices have six neighbours and lie on a lattice, old ones stay and new ones are
// midpoints: linear functions are reproduced. The finer lattice has steps of 2^-levels; two rings from the
// rim its corners are not felt.
TEST(Surfaces, KeepLattices) {
  constexpr int n = 8, levels = 3;
  const FineSurface fine(sheet(n), levels);
  int n_inside = 0;
  std::set<std::pair<long, long>> seen;
  for (int v = 0; v < fine.n_vertices; ++v) {
    const RowVector3d p = fine.point(v);
    const double y = p.y() / 0.8, x = p.x() - 0.5 * y;
    if (std::min({x, y, n - x, n - y}) < 1.999) continue;
    ++n_inside;
    const double i = x * (1 << levels), j = y * (1 << levels);
    EXPECT_NEAR(i, std::round(i), 1e-4);
    EXPECT_NEAR(j, std::round(j), 1e-4);
    seen.insert({std::lround(i), std::lround(j)});
  }
  EXPECT_EQ(n_inside, (4 * 8 + 1) * (4 * 8 + 1));
  EXPECT_EQ(static_cast<int>(seen.size()), n_inside);
}

// Claim: the rim of an open surface knows nothing but the rim (1/2, 1/2 and 1/8, 6/8, 1/8), whatever the
// inside does.
TEST(Surfaces, RimsFollowTheRim) {
  constexpr int n = 4, levels = 3;
  const Body body = sheet(n);
  FineSurface fine(body, levels);
  Points field = random_field(body);
  const Points before = fine.deform(field);
  for (int y = 1; y < n; ++y) {
    for (int x = 1; x < n; ++x) field.row(y * (n + 1) + x).setConstant(100);
  }
  const Points after = fine.deform(field);
  std::map<std::pair<int, int>, int> triangles_of;
  for (int t = 0; t < fine.n_triangles; ++t) {
    for (int k = 0; k < 3; ++k) ++triangles_of[std::minmax({fine.corner(t, k), fine.corner(t, (k + 1) % 3)})];
  }
  int n_rim = 0;
  for (const auto& [edge, count] : triangles_of) {
    if (count != 1) continue;
    ++n_rim;
    EXPECT_EQ(before.row(edge.first), after.row(edge.first));
  }
  EXPECT_EQ(n_rim, 4 * n << levels);

  FineSurface one(body, 1);
  const Points u = one.deform(random_field(body));
  field = random_field(body);
  const RowVector3d expected = (field.row(1) + 6 * field.row(2) + field.row(3)) / 8;
  EXPECT_LE((u.row(2) - expected).norm(), subdivision_rounding);
}

// Claim: a closed surface becomes smooth: from level to level the largest angle between neighbouring
// triangles halves, and so it does in the limit of a surface whose curvature stays bounded. 0.4 to 0.6 of the
// level before.
TEST(Surfaces, BecomeSmooth) {
  double before = 0;
  for (int levels = 1; levels <= 5; ++levels) {
    const FineSurface fine(icosahedron(), levels);
    std::map<std::pair<int, int>, RowVector3d> normal_at;
    double largest = 0;
    for (int t = 0; t < fine.n_triangles; ++t) {
      const RowVector3d a = fine.point(fine.corner(t, 0)), b = fine.point(fine.corner(t, 1)),
                        c = fine.point(fine.corner(t, 2));
      const RowVector3d normal = (b - a).cross(c - a).normalized();
      EXPECT_GT(normal.dot(a), 0);
      for (int k = 0; k < 3; ++k) {
        const auto [at, first] =
            normal_at.insert({std::minmax({fine.corner(t, k), fine.corner(t, (k + 1) % 3)}), normal});
        if (!first) largest = std::max(largest, std::acos(std::min(1.0, normal.dot(at->second))));
      }
    }
    if (levels > 1) {
      EXPECT_GT(largest / before, 0.4);
      EXPECT_LT(largest / before, 0.6);
    }
    before = largest;
  }
}

}  // namespace
