// A response set small enough for tests: 40 nodes, 26 directions x 4 increments, smooth and nonlinear.
#pragma once

#include <cmath>
#include <phynness/training/modal_fit.hpp>
#include <phynness/training/training.hpp>
#include <vector>

namespace phynness::test {

inline constexpr int n_nodes = 40, n_increments = 4;

/// Nodes on a bent, stretched spiral; all are output.
/// @param apart  every so-manieth is active; the time of a training is that of its active nodes
inline DatabaseHeader small_header(int apart = 3) {
  DatabaseHeader header;
  header.mesh.nodes.resize(n_nodes, 3);
  for (int i = 0; i < n_nodes; ++i) {
    const double z = 1 - (2 * i + 1.0) / n_nodes, ring = std::sqrt(1 - z * z);
    header.mesh.nodes.row(i) << 0.05 * ring * std::cos(2.4 * i), 0.04 * ring * std::sin(2.4 * i), 0.03 * z;
    header.sets.output.push_back(i);
    if (i % apart == 0) header.sets.active.push_back(i);
  }
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const double size = std::sqrt(static_cast<double>(x * x + y * y + z * z));
        if (size > 0) header.directions.push_back({x / size, y / size, z / size});
      }
    }
  }
  for (int i = 1; i <= n_increments; ++i) header.magnitudes_m.push_back(0.003 * i);
  header.sets.tools = single_nodes(header.sets.active);
  header.mesh_hash = "0123456789abcdef";
  header.physics_hash = "fedcba9876543210";
  header.software_version = "test";
  return header;
}

inline std::vector<Ray> small_rays(const DatabaseHeader& header, std::int32_t active) {
  std::vector<Ray> rays;
  const Eigen::RowVector3d touched = header.mesh.nodes.row(header.sets.active[active]);
  for (std::size_t k = 0; k < header.directions.size(); ++k) {
    Ray ray;
    ray.active = active;
    ray.direction = static_cast<std::int32_t>(k);
    ray.status.assign(header.magnitudes_m.size(), Status::converged);
    for (const double magnitude : header.magnitudes_m) {
      const Vec3& e = header.directions[k];
      const Eigen::RowVector3d d(magnitude * e[0], magnitude * e[1], magnitude * e[2]);
      const Eigen::RowVector3d force = (30 + active) * d * (1 + 2000 * d.squaredNorm() + 8 * d[2]);
      ray.force.insert(ray.force.end(), force.begin(), force.end());
      for (const std::int32_t o : header.sets.output) {
        const Eigen::RowVector3d x = header.mesh.nodes.row(o) - touched - 0.5 * d;
        const double r2 = x.squaredNorm() + 1e-4;
        const Eigen::RowVector3d u = 0.01 / std::sqrt(r2) * (d + x * (x.dot(d) / r2));
        ray.displacement.insert(ray.displacement.end(), u.begin(), u.end());
      }
    }
    rays.push_back(std::move(ray));
  }
  return rays;
}

/// Networks small enough that a test trains in a moment.
inline TrainingSpec small_spec() {
  TrainingSpec spec;
  spec.family = Family::rbfn;
  spec.deformation_neurons = 40;
  spec.force_neurons = 30;
  spec.deformation_spread = 0.75;
  spec.force_spread = 1.4;
  spec.samples = 800;
  return spec;
}

inline TrainingSpec modal_spec() {
  TrainingSpec spec;
  spec.family = Family::modal;
  spec.modes = 12;
  spec.shared_modes = 40;
  spec.near_nodes = 6;
  return spec;
}

/// By plain loops over a modal model, at x = d / R: the sum of modes with the amplitudes of a node, with its near rows
/// in place of theirs.
/// @param degree  of a field, a number at each node; 0: a displacement
inline Eigen::VectorXd modal_values(const Model& model, const ScaledTable& modes, const ModalDeformation& of_node,
                                    const Eigen::Vector3d& x, int degree = 0) {
  const auto n_centers = static_cast<Eigen::Index>(model.shared.centers.size()),
             each = Eigen::Index(degree > 0 ? 1 : 3);
  const double s = model.shared.shape;
  const auto q = [s](const Eigen::Vector3d& y) { return std::sqrt(y.squaredNorm() + s * s); };
  Eigen::VectorXd basis(n_centers + (degree > 0 ? 9 : 3));
  for (Eigen::Index i = 0; i < n_centers; ++i) {
    const Eigen::Vector3d c = model.displacements.row(model.shared.centers[static_cast<std::size_t>(i)]).transpose() /
                              model.max_displacement_m;
    basis[i] = q(x - c) - q(x) - q(c) + s;
  }
  basis.segment<3>(n_centers) = x;
  if (degree > 0) basis.tail<6>() = even_features(x, degree);
  const Eigen::VectorXd a = of_node.weights.values().transpose() * basis;
  Eigen::VectorXd values = modes.values() * (of_node.mixing.values() * a);
  const Eigen::VectorXd near = of_node.near_modes.values() * a;
  for (std::size_t i = 0; i < of_node.near.size(); ++i)
    values.segment(each * of_node.near[i], each) = near.segment(each * static_cast<Eigen::Index>(i), each);
  return values;
}

inline ResponseSource source_of(const DatabaseHeader& header) {
  return {&header, [&header](std::int32_t active) { return small_rays(header, active); }, {}, "small"};
}

}  // namespace phynness::test
