// Bodies for contact: a ball and a thin plate with the compliance C_ij = k(|x_i - x_j|) S, where k is a Gaussian and S
// a matrix that adds a small tangential component; linear, or with a small nonlinearity like modal models.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "../runtime/linear_body.hpp"

namespace phynness::test {

using Eigen::Vector3d;

struct Skin {
  std::vector<Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
  int n_fixed = 0;  ///< the last points

  int midpoint(std::map<std::pair<int, int>, int>& known, int a, int b) {
    const auto [at, is_new] = known.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(points.size()));
    const Vector3d sum = points[static_cast<std::size_t>(a)] + points[static_cast<std::size_t>(b)];
    if (is_new) points.push_back(sum.normalized());
    return at->second;
  }
};

/// Radius 5 cm: an octahedron divided three times, 258 vertices, 512 triangles. Its vertices lie on three
/// great circles. Divided once: 18 and 32.
inline Skin ball(int divisions = 3) {
  Skin s;
  for (int k = 0; k < 3; ++k) {
    s.points.push_back(Vector3d::Unit(k));
    s.points.push_back(-Vector3d::Unit(k));
  }
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z) {
        const bool even = (x + y + z) % 2 == 0;
        s.triangles.push_back({x, even ? 2 + y : 4 + z, even ? 4 + z : 2 + y});
      }
  for (int level = 0; level < divisions; ++level) {
    std::map<std::pair<int, int>, int> known;
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : s.triangles) {
      const int ab = s.midpoint(known, a, b), bc = s.midpoint(known, b, c), ca = s.midpoint(known, c, a);
      for (const std::array<int, 3>& t : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(t);
    }
    s.triangles = finer;
  }
  for (Vector3d& x : s.points) x *= 0.05;
  return s;
}

/// 10 x 10 cm, `thickness` thin, the middle at 0: 10 x 10 squares on either side, 242 vertices.
inline Skin plate(double thickness) {
  Skin s;
  constexpr int n = 10;
  const auto at = [](int side, int x, int y) { return (side * (n + 1) + y) * (n + 1) + x; };
  for (int side = 0; side < 2; ++side)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x)
        s.points.push_back({0.1 * x / n - 0.05, 0.1 * y / n - 0.05, (side - 0.5) * thickness});
  const auto square = [&](int a, int b, int c, int d) {
    s.triangles.push_back({a, b, c});
    s.triangles.push_back({a, c, d});
  };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      square(at(0, x, y), at(0, x, y + 1), at(0, x + 1, y + 1), at(0, x + 1, y));
      square(at(1, x, y), at(1, x + 1, y), at(1, x + 1, y + 1), at(1, x, y + 1));
    }
  for (int i = 0; i < n; ++i) {
    square(at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
    square(at(0, n, i), at(0, n, i + 1), at(1, n, i + 1), at(1, n, i));
    square(at(0, i + 1, n), at(0, i, n), at(1, i, n), at(1, i + 1, n));
    square(at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1));
  }
  return s;
}

/// A ball whose lowest vertices are fixed.
inline Skin held_ball(int divisions = 3) {
  const Skin whole = ball(divisions);
  std::vector<int> order, place(whole.points.size());
  for (int fixed = 0; fixed < 2; ++fixed)
    for (int i = 0; i < static_cast<int>(whole.points.size()); ++i)
      if ((whole.points[static_cast<std::size_t>(i)].z() < -0.035) == (fixed == 1)) order.push_back(i);
  Skin s;
  for (const int i : order) {
    place[static_cast<std::size_t>(i)] = static_cast<int>(s.points.size());
    s.points.push_back(whole.points[static_cast<std::size_t>(i)]);
    s.n_fixed += s.points.back().z() < -0.035;
  }
  for (auto triangle : whole.triangles) {
    for (int& corner : triangle) corner = place[static_cast<std::size_t>(corner)];
    s.triangles.push_back(triangle);
  }
  return s;
}

/// Some 50 N/m at a node; 2 cm reach.
inline Model linear_model(const Skin& shape) {
  Model model = bare_model(shape.points, shape.triangles, shape.n_fixed);
  Eigen::Matrix3d aside;
  aside << 1, 0.1, -0.05, 0.1, 1.2, 0.15, -0.05, 0.15, 0.9;
  const int n = static_cast<int>(model.output.size());
  const Eigen::Matrix3d stiffness = 50 * aside.inverse();
  for (int i = 0; i < n; ++i) {
    ActiveNodeModel& node = model.nodes.emplace_back();
    node.node = i;
    for (int k = 0; k < 3; ++k) node.point[k] = model.output_points(i, k);
    node.prescribed = {i};
    node.prescribed_weight = {1};
    node.trained_depth_m = {0.01, 0.01, 0.01, 0.01};
    node.linear.stiffness = (stiffness + stiffness.transpose()) / 2;
    node.linear.unit_responses.resize(n, 9);
    for (int o = 0; o < n; ++o) {
      const double d = (model.output_points.row(i) - model.output_points.row(o)).norm() / 0.02;
      for (int e = 0; e < 9; ++e) node.linear.unit_responses(o, e) = e % 4 == 0 ? std::exp(-d * d) : 0;
    }
  }
  return model;
}

/// The same, stiffening and softening by some per cent, as kernels do, alike at every node.
inline Model bent_model(const Skin& shape) {
  Numbers numbers;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> b;
  for (double& value : b.reshaped<Eigen::RowMajor>()) value = static_cast<float>(0.01 * numbers.next());
  Eigen::Vector4d w;
  for (double& value : w) value = 0.0005 * numbers.next();
  return modal_model_of(linear_model(shape), [&](auto& coefficients, auto weights) {
    coefficients = b;
    weights.colwise() = w;
  });
}

}  // namespace phynness::test
