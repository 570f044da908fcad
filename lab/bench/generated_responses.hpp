// Response sets of the size of the paper's liver without a solver: smooth nonlinear fields around every active node.
#pragma once

#include <cmath>
#include <numbers>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness::bench {

inline constexpr std::int32_t n_nodes = 486, n_increments = 6;
inline constexpr double depth_m = 0.028;

/// Surface of an ellipsoid of 20 x 14 x 8 cm, with nodes on a Fibonacci spiral. Every node is active and an output
/// node.
inline DatabaseHeader liver_sized_header() {
  DatabaseHeader header;
  header.mesh.nodes.resize(n_nodes, 3);
  for (std::int32_t i = 0; i < n_nodes; ++i) {
    const double z = 1 - (2 * i + 1.0) / n_nodes, ring = std::sqrt(1 - z * z),
                 turn = std::numbers::phi * 2 * std::numbers::pi * i;
    header.mesh.nodes.row(i) << 0.10 * ring * std::cos(turn), 0.07 * ring * std::sin(turn), 0.04 * z;
    header.sets.active.push_back(i);
    header.sets.output.push_back(i);
  }
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const double size = std::sqrt(static_cast<double>(x * x + y * y + z * z));
        if (size > 0) header.directions.push_back({x / size, y / size, z / size});
      }
  for (int i = 1; i <= n_increments; ++i) header.magnitudes_m.push_back(depth_m * i / n_increments);
  header.sets.tools = single_nodes(header.sets.active);
  return header;
}

/// Displacement at X [m] if the node at `touched` moves by d: the regularized Kelvin solution for a point force, with a
/// nonlinear dependence on d, so that directions are independent.
inline Eigen::RowVector3d field(const Eigen::RowVector3d& X, const Eigen::RowVector3d& touched,
                                const Eigen::RowVector3d& d) {
  constexpr double core = 0.02, poisson = 0.48;
  const Eigen::RowVector3d x = X - touched - 0.5 * d;
  const double r2 = x.squaredNorm() + core * core;
  const double decay = core / std::sqrt(r2);
  return decay * ((3 - 4 * poisson) * d + x * (x.dot(d) / r2)) / (3 - 4 * poisson + 0.2);
}

inline std::vector<Ray> rays(const DatabaseHeader& header, std::int32_t active) {
  std::vector<Ray> rays;
  const Eigen::RowVector3d touched = header.mesh.nodes.row(header.sets.active[active]);
  for (std::size_t direction = 0; direction < header.directions.size(); ++direction) {
    Ray ray;
    ray.active = active;
    ray.direction = static_cast<std::int32_t>(direction);
    ray.status.assign(n_increments, Status::converged);
    ray.displacement.reserve(3 * n_nodes * n_increments);
    for (const double magnitude : header.magnitudes_m) {
      const Vec3& e = header.directions[direction];
      const Eigen::RowVector3d d(magnitude * e[0], magnitude * e[1], magnitude * e[2]);
      // A spring whose stiffness increases with depth and is smaller in tangential directions.
      const Eigen::RowVector3d force =
          20 * d.cwiseProduct(Eigen::RowVector3d(1, 1.3, 0.8)) * (1 + 300 * d.squaredNorm() + 5 * d[2]);
      ray.force.insert(ray.force.end(), force.begin(), force.end());
      for (const std::int32_t o : header.sets.output) {
        const Eigen::RowVector3d u = field(header.mesh.nodes.row(o), touched, d);
        ray.displacement.insert(ray.displacement.end(), u.begin(), u.end());
      }
    }
    rays.push_back(std::move(ray));
  }
  return rays;
}

}  // namespace phynness::bench
