// Structured blocks of tetrahedra, made so that a test knows every node; and the same with an irregular interior.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <phynness/formats/mesh.hpp>
#include <random>
#include <set>

namespace phynness::test {

/// Numbers that repeat on every machine (the standard's distributions may differ); the seed is printed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : _engine(seed) {
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  }
  /// Uniform in [-1, 1).
  double operator()() { return std::ldexp(static_cast<double>(_engine() >> 11), -52) - 1; }
  std::uint64_t below(std::uint64_t n) { return _engine() % n; }

 private:
  std::mt19937_64 _engine;
};

/// The block [0, size] cut into boxes, each box into the six tetrahedra of Kuhn along its main diagonal. Node (i, j, k)
/// has number (k (n_y + 1) + j) (n_x + 1) + i. The mesh is its own image under inversion through the center.
inline Mesh block_mesh(const std::array<int, 3>& boxes, const std::array<double, 3>& size) {
  const auto [nx, ny, nz] = boxes;
  const auto number = [nx = nx, ny = ny](const std::array<int, 3>& q) {
    return (q[2] * (ny + 1) + q[1]) * (nx + 1) + q[0];
  };
  Mesh mesh;
  mesh.nodes.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  mesh.cells.resize(6 * nx * ny * nz, 4);
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.nodes.row(number({i, j, k})) << size[0] * i / nx, size[1] * j / ny, size[2] * k / nz;

  // Each path from corner (0,0,0) to (1,1,1) along the axes is a tetrahedron; odd orders of axes are mirrored.
  constexpr int axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  Eigen::Index cell = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int path = 0; path < 6; ++path, ++cell) {
          std::array<int, 3> corner{i, j, k};
          mesh.cells(cell, 0) = number(corner);
          for (int step = 0; step < 3; ++step) {
            ++corner[axes[path][step]];
            mesh.cells(cell, step + 1) = number(corner);
          }
          if (path >= 3) std::swap(mesh.cells(cell, 2), mesh.cells(cell, 3));
        }
  mesh.surface = boundary_triangles(mesh.cells);
  return mesh;
}

inline std::set<std::int32_t> interior_nodes(const Mesh& mesh) {
  std::set<std::int32_t> interior;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) interior.insert(i);
  for (const auto node : surface_nodes(mesh.surface)) interior.erase(node);
  return interior;
}

inline double volume(const Mesh& mesh) {
  double sum = 0;
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c) {
    Eigen::Matrix3d edges;
    for (int i = 0; i < 3; ++i) edges.row(i) = mesh.nodes.row(mesh.cells(c, i + 1)) - mesh.nodes.row(mesh.cells(c, 0));
    sum += edges.determinant() / 6;
  }
  return sum;
}

/// Moves the interior nodes by up to `distance` in each component, so that no symmetry of the mesh hides a mistake.
inline Mesh irregular(Mesh mesh, double distance, Random& random) {
  for (const auto node : interior_nodes(mesh))
    for (int k = 0; k < 3; ++k) mesh.nodes(node, k) += distance * random();
  return mesh;
}

}  // namespace phynness::test
