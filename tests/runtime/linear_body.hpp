// Bodies with known solutions: linear ones, and the same with a small nonlinearity.
#pragma once

#include <phynness/phynness.h>

#include <Eigen/LU>
#include <array>
#include <vector>

#include "small_model.hpp"

namespace phynness::test {

/// Points, of which the last n_fixed are fixed, and triangles between them, without any response.
template <class Point>
Model bare_model(const std::vector<Point>& points, const std::vector<std::array<int, 3>>& triangles, int n_fixed) {
  Model model = small_linear_model();
  const auto n = static_cast<std::int32_t>(points.size()), n_output = n - n_fixed;
  model.n_mesh_nodes = n;
  model.output.clear();
  model.fixed.clear();
  model.nodes.clear();
  model.output_points.resize(n_output, 3);
  model.fixed_points.resize(n_fixed, 3);
  for (std::int32_t i = 0; i < n; ++i) {
    const bool moves = i < n_output;
    (moves ? model.output : model.fixed).push_back(i);
    for (int k = 0; k < 3; ++k)
      (moves ? model.output_points : model.fixed_points)(moves ? i : i - n_output, k) =
          points[static_cast<std::size_t>(i)][k];
  }
  model.surface.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (Eigen::Index t = 0; t < model.surface.rows(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      model.surface(t, static_cast<Eigen::Index>(k)) = triangles[static_cast<std::size_t>(t)][k];
  return model;
}

/// A linear model as a modal one: three modes that are the unit responses, and the curvature that
/// curve(coefficients of the force's three kernels, weights of the four amplitude kernels) sets. Tables round to 16
/// bits: responses to each other agree to some 1e-5.
template <class Curve>
Model modal_model_of(Model model, const Curve& curve) {
  model.family = Family::modal;
  model.shared = {
      scaled_table(Eigen::MatrixXd(static_cast<Eigen::Index>(3 * model.output.size()), 0)), {0, 3, 5, 6}, 0.5};
  for (ActiveNodeModel& node : model.nodes) {
    node.conservative.shape = 0.3;
    node.conservative.stiffness = node.linear.stiffness;
    node.conservative.centers = {1, 4, 7};
    node.conservative.coefficients.setZero(3, 3);
    Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(7, 3);
    curve(node.conservative.coefficients, weights.topRows<4>());
    weights.bottomRows<3>() = model.max_displacement_m * Eigen::Matrix3d::Identity();
    Eigen::MatrixXd modes(3 * node.linear.unit_responses.rows(), 3);
    for (Eigen::Index o = 0; o < node.linear.unit_responses.rows(); ++o) {
      for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis) modes(3 * o + k, axis) = node.linear.unit_responses(o, 3 * axis + k);
      node.modal.near.push_back(static_cast<std::int32_t>(o));
    }
    node.modal.weights = scaled_table(weights);
    node.modal.mixing = scaled_table(Eigen::MatrixXd(0, 3));
    node.modal.near_modes = scaled_table(modes);
  }
  return model;
}

/// A linear body of n free nodes given by its compliance, u = C f, and node n fixed; every node active and output.
struct LinearBody {
  Eigen::MatrixXd compliance;
  Model model;

  /// @param coupled  false: nodes on springs of their own, which take no notice of each other
  explicit LinearBody(int n, bool coupled = true) {
    Numbers numbers;
    Eigen::MatrixXd A(3 * n, 3 * n);
    for (int i = 0; i < 3 * n; ++i)
      for (int j = 0; j < 3 * n; ++j) A(i, j) = 0.3 * numbers.next();
    compliance = (A * A.transpose() + Eigen::MatrixXd::Identity(3 * n, 3 * n)) / 50;
    for (int i = 0; i < 3 * n && !coupled; ++i)
      for (int j = 0; j < 3 * n; ++j) compliance(i, j) *= i / 3 == j / 3;
    std::vector<Vec3> points(static_cast<std::size_t>(n));
    for (Vec3& point : points)
      for (double& x : point) x = 0.05 * numbers.next();
    points.push_back({0, 0, -0.1});
    std::vector<std::array<int, 3>> triangles;  // uncoupled nodes do not turn with each other either
    for (int i = 0; i < n && coupled; ++i) triangles.push_back({i, (i + 1) % n, i == 0 ? n : (i + 2) % n});
    model = bare_model(points, triangles, 1);
    for (int i = 0; i < n; ++i) {
      ActiveNodeModel& node = model.nodes.emplace_back();
      node.node = i;
      for (int k = 0; k < 3; ++k) node.point[k] = model.output_points(i, k);
      node.prescribed = {i};
      node.prescribed_weight = {1};
      node.trained_depth_m = {0.01, 0.01, 0.01, 0.01};
      const Eigen::Matrix3d K = Eigen::Matrix3d(compliance.block<3, 3>(3 * i, 3 * i)).inverse();
      node.linear.stiffness = (K + K.transpose()) / 2;
      node.linear.unit_responses.resize(n, 9);
      for (int o = 0; o < n; ++o) {
        const Eigen::Matrix3d U = o == i ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                         : Eigen::Matrix3d(compliance.block<3, 3>(3 * o, 3 * i) * K);
        for (int axis = 0; axis < 3; ++axis)
          for (int k = 0; k < 3; ++k) node.linear.unit_responses(o, 3 * axis + k) = U(k, axis);
      }
    }
  }
};

/// The same body with a little curvature that bends force and amplitudes by up to a tenth.
inline Model bent(const LinearBody& body) {
  Numbers numbers;
  return modal_model_of(body.model, [&](auto& coefficients, auto weights) {
    for (double& b : coefficients.reshaped()) b = 0.01 * numbers.next();
    for (auto row : weights.rowwise()) row.setConstant(0.0005 * numbers.next());
  });
}

inline phn_tool tool(std::int32_t a, std::int32_t b, std::int32_t c, double wa, double wb, double dx, double dy,
                     double dz) {
  return {{a, b, c}, {wa, wb, 1 - wa - wb}, {dx, dy, dz}};
}

}  // namespace phynness::test
