// Models of the size of the paper's liver with arbitrary coefficients, on which times do not depend.
#pragma once

#include <cmath>
#include <numbers>
#include <phynness/formats/model.hpp>
#include <random>

namespace phynness::bench {

inline constexpr int n_output = 486, n_fixed = 110, n_rings = 27, n_around = 22;
static_assert(n_rings * n_around + 2 == n_output + n_fixed);

/// Triangles of rings between two poles, oriented outward.
inline Triangles ringed_triangles() {
  Triangles triangles(2 * n_rings * n_around, 3);
  const auto at = [](int ring, int i) { return 1 + ring * n_around + i % n_around; };
  Eigen::Index t = 0;
  for (int i = 0; i < n_around; ++i) {
    triangles.row(t++) << 0, at(0, i), at(0, i + 1);
    triangles.row(t++) << n_output + n_fixed - 1, at(n_rings - 1, i + 1), at(n_rings - 1, i);
    for (int r = 0; r + 1 < n_rings; ++r) {
      triangles.row(t++) << at(r, i), at(r + 1, i), at(r + 1, i + 1);
      triangles.row(t++) << at(r, i), at(r + 1, i + 1), at(r, i + 1);
    }
  }
  return triangles;
}

inline Eigen::RowVector3d ellipsoid_point(int node) {
  const int ring = (node - 1 + n_around) / n_around, i = (node - 1 + n_around) % n_around;
  const bool pole = node == 0 || node == n_output + n_fixed - 1;
  const double polar = node == 0 ? 0 : pole ? std::numbers::pi : std::numbers::pi * ring / (n_rings + 1);
  const double turn = 2 * std::numbers::pi * i / n_around;
  return {0.10 * std::sin(polar) * std::cos(turn), 0.07 * std::sin(polar) * std::sin(turn), 0.04 * std::cos(polar)};
}

/// A closed surface of 596 vertices, of which the first n_moving are output nodes and all others are fixed. It has no
/// active nodes yet.
inline Model liver_sized_body(Family family, int n_moving = n_output) {
  Model model;
  model.family = family;
  model.title = "bench";
  model.max_displacement_m = 0.028;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const double size = std::sqrt(static_cast<double>(x * x + y * y + z * z));
        if (size > 0) model.directions.push_back({x / size, y / size, z / size});
      }
  constexpr int n_increments = 6;
  model.displacements.resize(static_cast<Eigen::Index>(model.directions.size()) * n_increments, 3);
  for (Eigen::Index i = 0; i < model.displacements.rows(); ++i)
    for (int k = 0; k < 3; ++k)
      model.displacements(i, k) = model.directions[static_cast<std::size_t>(i / n_increments)][k] *
                                  model.max_displacement_m * static_cast<double>(i % n_increments + 1) / n_increments;
  model.n_mesh_nodes = n_output + n_fixed;
  model.output_points.resize(n_moving, 3);
  model.fixed_points.resize(n_output + n_fixed - n_moving, 3);
  for (int i = 0; i < n_output + n_fixed; ++i) {
    const bool moves = i < n_moving;
    (moves ? model.output : model.fixed).push_back(i);
    (moves ? model.output_points : model.fixed_points).row(moves ? i : i - n_moving) = ellipsoid_point(i);
  }
  model.surface = ringed_triangles();
  return model;
}

class Arbitrary {
 public:
  double number() { return _uniform(_engine); }  ///< in [-1, 1]
  int below(int n) { return static_cast<int>(_engine() % static_cast<unsigned>(n)); }
  ScaledTable table(Eigen::Index n_rows, Eigen::Index n_columns, double size) {
    Eigen::MatrixXd values(n_rows, n_columns);
    for (Eigen::Index i = 0; i < values.size(); ++i) values(i) = size * number();
    return scaled_table(values);
  }

 private:
  std::mt19937 _engine{1};
  std::uniform_real_distribution<double> _uniform{-1, 1};
};

inline ActiveNodeModel& add_node(Model& model, int node) {
  ActiveNodeModel& added = model.nodes.emplace_back();
  added.node = node;
  for (int k = 0; k < 3; ++k) added.point[k] = model.output_points(node, k);
  added.prescribed = {node};
  added.prescribed_weight = {1};
  added.trained_depth_m.assign(model.directions.size(), model.max_displacement_m);
  return added;
}

/// A model in which every node has its own networks.
inline Model networks_model(int n_force, int n_deformation, int n_active, int n_moving = n_output) {
  Model model = liver_sized_body(Family::rbfn, n_moving);
  Arbitrary arbitrary;
  for (int a = 0; a < n_active; ++a) {
    ActiveNodeModel& node = add_node(model, a * n_moving / n_active);
    for (const bool deforms : {false, true}) {
      RbfNetwork& net = deforms ? node.deformation : node.force;
      const int n = deforms ? n_deformation : n_force, n_inputs = deforms ? 6 : 3;
      net.input_center = Eigen::VectorXd::Zero(n_inputs);
      net.input_half_range = Eigen::VectorXd::Constant(n_inputs, 0.028);
      if (deforms) net.input_half_range.tail(3) << 0.10, 0.07, 0.04;
      net.output_center = Eigen::VectorXd::Zero(3);
      net.output_half_range = Eigen::VectorXd::Ones(3);
      net.spread = 1.4;
      net.weights.resize(n, 3);
      for (int i = 0; i < n; ++i) {
        net.center_displacement.push_back(arbitrary.below(static_cast<int>(model.displacements.rows())));
        if (deforms) net.center_output.push_back(arbitrary.below(n_moving));
        for (int k = 0; k < 3; ++k) net.weights(i, k) = 0.001 * arbitrary.number();
      }
      fill_centers(model, net);
    }
  }
  return model;
}

/// Modes of the same numbers as training gives for the paper's liver.
inline Model modal_model(int n_force, int n_shared, int n_own, int n_centers, int n_near, int n_active,
                         int n_moving = n_output) {
  Model model = liver_sized_body(Family::modal, n_moving);
  Arbitrary arbitrary;
  model.shared.modes = arbitrary.table(3 * n_moving, n_shared, 0.1);
  for (int i = 0; i < n_centers; ++i) model.shared.centers.push_back(2 * i);
  for (int a = 0; a < n_active; ++a) {
    ActiveNodeModel& node = add_node(model, a * n_moving / n_active);
    node.conservative.stiffness = 10 * Eigen::Matrix3d::Identity();
    node.conservative.coefficients.resize(n_force, 3);
    for (int i = 0; i < n_force; ++i) {
      node.conservative.centers.push_back(i % static_cast<int>(model.displacements.rows()));
      for (int k = 0; k < 3; ++k) node.conservative.coefficients(i, k) = static_cast<float>(0.01 * arbitrary.number());
    }
    ModalDeformation& modal = node.modal;
    modal.weights = arbitrary.table(n_centers + 3, n_own, 0.01);
    modal.mixing = arbitrary.table(n_shared, n_own, 1);
    const int step = 3 * n_near <= n_moving ? 3 : 1;
    for (int i = 0; i < n_near; ++i) modal.near.push_back((node.node / 2 + step * i) % n_moving);
    std::sort(modal.near.begin(), modal.near.end());
    modal.near_modes = arbitrary.table(3 * n_near, n_own, 1);
  }
  return model;
}

}  // namespace phynness::bench
