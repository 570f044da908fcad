// Surfaces in the runtime: closed ones, open ones and some that are not manifolds.
#pragma once

#include <gtest/gtest.h>
#include <phynness/phynness_surface.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <vector>

#include "linear_body.hpp"
#include "loaded_model.hpp"

namespace phynness::test {

using Eigen::RowVector3d;
using Corners = std::array<int, 3>;

/// A triangulated surface without any response. The last n_fixed points are fixed nodes.
struct Body {
  std::vector<RowVector3d> points;
  std::vector<Corners> triangles;
  int n_fixed = 0;

  int n_output() const { return static_cast<int>(points.size()) - n_fixed; }
};

inline std::string text_of(const Body& body) {
  return write_model_text(bare_model(body.points, body.triangles, body.n_fixed));
}

struct FineSurface {
  FineSurface(const Body& body, int levels) : loaded(text_of(body)) {
    std::size_t bytes = 0;
    LoadedModel::check(phn_surface_size(loaded.model, levels, &bytes));
    memory.resize(bytes);
    LoadedModel::check(phn_surface_init(memory.data(), bytes, loaded.model, levels, &surface));
    scratch.resize(contents_of(surface).scratch_bytes / sizeof(float));
    n_vertices = contents_of(surface).n_vertices;
    n_triangles = contents_of(surface).n_triangles;
  }
  RowVector3d point(int vertex) const {
    return Eigen::Map<const Eigen::RowVector3f>(contents_of(surface).points + 3 * vertex).cast<double>();
  }
  int corner(int triangle, int k) const { return contents_of(surface).triangles[3 * triangle + k]; }
  Points deform(const Points& field) {
    Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> out(n_vertices, 3);
    out.setConstant(std::numeric_limits<float>::quiet_NaN());
    std::fill(scratch.begin(), scratch.end(), std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(phn_surface_deform(surface, scratch.data(), field.data(), out.data()), PHN_OK);
    return out.cast<double>();
  }

  LoadedModel loaded;
  std::vector<char> memory;
  std::vector<float> scratch;
  const phn_surface* surface = nullptr;
  int n_vertices = 0, n_triangles = 0;
};

inline Body tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

inline Body icosahedron() {
  const double g = std::numbers::phi;
  return {{{-1, g, 0},
           {1, g, 0},
           {-1, -g, 0},
           {1, -g, 0},
           {0, -1, g},
           {0, 1, g},
           {0, -1, -g},
           {0, 1, -g},
           {g, 0, -1},
           {g, 0, 1},
           {-g, 0, -1},
           {-g, 0, 1}},
          {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
}

/// An open sheet of n x n squares, each two triangles: interior vertices have six neighbours.
inline Body sheet(int n) {
  Body body;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) body.points.push_back({x + 0.5 * y, 0.8 * y, 0});
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      body.triangles.push_back({a, b, c});
      body.triangles.push_back({b, d, c});
    }
  return body;
}

/// Triangles between vertices drawn at random: edges of one, two and more triangles, vertices of several
/// parts, triangles that occur twice, vertices without any.
inline Body soup(int n_points, int n_triangles) {
  Numbers numbers;
  Body body;
  body.n_fixed = 2;
  for (int i = 0; i < n_points; ++i) body.points.push_back({numbers.next(), numbers.next(), numbers.next()});
  const auto draw = [&] { return static_cast<int>((numbers.next() + 1) / 2 * n_points * 0.999); };
  while (static_cast<int>(body.triangles.size()) < n_triangles) {
    const Corners t = {draw(), draw(), draw()};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) body.triangles.push_back(t);
  }
  body.triangles.push_back(body.triangles.front());
  return body;
}

inline std::vector<Body> bodies() {
  std::vector<Body> all = {tetrahedron(), icosahedron(), sheet(3), soup(12, 14), soup(9, 30), soup(40, 20)};
  all.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}});  // a pillow
  all.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}},     // three pages of a book
                 {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}});
  all.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {5, 5, 5}},  // a bow, and a lone vertex
                 {{0, 1, 2}, {0, 3, 4}},
                 1});
  // An edge of four triangles that ends at vertex 0.
  all.push_back({{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {0, -1, 0}, {-1, -1, 0}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 4}, {0, 4, 5}, {0, 5, 1}},
                 2});
  all.push_back({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, 3});  // nothing moves
  return all;
}

}  // namespace phynness::test
