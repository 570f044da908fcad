// The tangent of a very small body as a dense matrix, for results of dense algebra that are independent of the solver.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "solve/discretization.hpp"

namespace phynness::test {

/// d(residual)/d(state), n_dofs x n_dofs.
inline Eigen::MatrixXd dense_tangent(Discretization& body, const std::vector<double>& state) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(body.n_dofs(), body.n_dofs());
  body.block_tangents(state, Convexity::none,
                      [&](std::int32_t block, std::span<const double> values, std::span<const double>) {
                        const auto dofs = body.block_dofs(block);
                        for (std::size_t i = 0; i < dofs.size(); ++i)
                          for (std::size_t j = 0; j < dofs.size(); ++j)
                            K(dofs[i], dofs[j]) += values[i * dofs.size() + j];
                      });
  return K;
}

inline Eigen::VectorXd residual(Discretization& body, const std::vector<double>& state) {
  std::vector<double> r(body.n_dofs());
  body.residual(state, r);
  return Eigen::Map<const Eigen::VectorXd>(r.data(), body.n_dofs());
}

}  // namespace phynness::test
