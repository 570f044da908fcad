// Bodies with known solutions: linear ones, and the same with a small nonlinearity.
#pragma once

#include <phynness/phynness.h>

#include <Eigen/LU>

#include "small_model.hpp"

namespace phynness::test {

/// A linear body of n free nodes given by its compliance, u = C f, and node n fixed; every node active and
/// output.
struct LinearBody {
  Eigen::MatrixXd compliance;
  Model model;

  /// @param coupled  false: nodes on springs of their own, which take no notice of each other
  explicit LinearBody(int n, bool coupled = true) {
    Numbers numbers;
    Eigen::MatrixXd A(3 * n, 3 * n);
    for (int i = 0; i < 3 * n; ++i) {
      for (int j = 0; j < 3 * n; ++j) A(i, j) = 0.3 * numbers.next();
    }
    compliance = (A * A.transpose() + Eigen::MatrixXd::Identity(3 * n, 3 * n)) / 50;
    for (int i = 0; i < 3 * n && !coupled; ++i) {
      for (int j = 0; j < 3 * n; ++j) compliance(i, j) *= i / 3 == j / 3;
    }
    model = small_linear_model();
    model.n_mesh_nodes = n + 1;
    model.fixed = {n};
    model.fixed_points.resize(1, 3);
    model.fixed_points << 0, 0, -0.1;
    model.output.clear();
    model.output_points.resize(n, 3);
    model.nodes.clear();
    for (int i = 0; i < n; ++i) {
      model.output.push_back(i);
      for (int k = 0; k < 3; ++k) model.output_points(i, k) = 0.05 * numbers.next();
    }
    model.surface.resize(n, 3);
    for (int i = 0; i < n; ++i) model.surface.row(i) << i, (i + 1) % n, i == 0 ? n : (i + 2) % n;
    if (!coupled) model.surface.resize(0, 3);  // nor turn with each other
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
        for (int axis = 0; axis < 3; ++axis) {
          for (int k = 0; k < 3; ++k) node.linear.unit_responses(o, 3 * axis + k) = U(k, axis);
        }
      }
    }
  }
};

/// The same body with a little curvature, as a modal model: three modes that are the unit responses, kernels
/// that bend force and amplitudes by up to a tenth. Tables round to 16 bits: responses to each other agree to
/// some 1e-5.
/// @param curved  false: without the curvature
inline Model bent(const LinearBody& body, bool curved = true) {
  Numbers numbers;
  Model model = body.model;
  model.family = Family::modal;
  model.shared = {
      scaled_table(Eigen::MatrixXd(static_cast<Eigen::Index>(3 * model.output.size()), 0)), {0, 3, 5, 6}, 0.5};
  for (ActiveNodeModel& node : model.nodes) {
    node.conservative.shape = 0.3;
    node.conservative.stiffness = node.linear.stiffness;
    node.conservative.centers = {1, 4, 7};
    node.conservative.coefficients.resize(3, 3);
    for (double& b : node.conservative.coefficients.reshaped()) b = curved ? 0.01 * numbers.next() : 0;
    Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(7, 3);
    for (Eigen::Index r = 0; r < 4; ++r) weights.row(r).setConstant(curved ? 0.0005 * numbers.next() : 0);
    weights.bottomRows<3>() = model.max_displacement_m * Eigen::Matrix3d::Identity();
    Eigen::MatrixXd modes(3 * node.linear.unit_responses.rows(), 3);
    for (Eigen::Index o = 0; o < node.linear.unit_responses.rows(); ++o) {
      for (int k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis) modes(3 * o + k, axis) = node.linear.unit_responses(o, 3 * axis + k);
      }
      node.modal.near.push_back(static_cast<std::int32_t>(o));
    }
    node.modal.weights = scaled_table(weights);
    node.modal.mixing = scaled_table(Eigen::MatrixXd(0, 3));
    node.modal.near_modes = scaled_table(modes);
  }
  return model;
}

inline phn_tool tool(std::int32_t a, std::int32_t b, std::int32_t c, double wa, double wb, double dx, double dy,
                     double dz) {
  return {{a, b, c}, {wa, wb, 1 - wa - wb}, {dx, dy, dz}};
}

}  // namespace phynness::test
