// The tangent of a very small body as a dense matrix, for results of dense algebra that are independent of the solver.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "discretization.hpp"

namespace phynness::test {

/// d(residual)/d(state), n_dofs x n_dofs.
inline Eigen::MatrixXd dense_tangent(Discretization& body, const std::vector<double>& state) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(body.n_dofs(), body.n_dofs());
  const int m = body.n_element_dofs();
  body.element_tangents(state, [&](std::int32_t cell, std::span<const double> values) {
    const auto dofs = body.element_dofs(cell);
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j) K(dofs[i], dofs[j]) += values[i * m + j];
  });
  return K;
}

inline Eigen::VectorXd residual(Discretization& body, const std::vector<double>& state) {
  std::vector<double> r(body.n_dofs());
  body.residual(state, r);
  return Eigen::Map<const Eigen::VectorXd>(r.data(), body.n_dofs());
}

}  // namespace phynness::test
