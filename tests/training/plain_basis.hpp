// The basis matrix of a network by plain loops, for independent dense solves.
#pragma once

#include <cmath>
#include <phynness/training/network_fit.hpp>

namespace phynness::test {

/// n x n_inputs, scaled by the transforms of `network`.
inline Eigen::MatrixXd scaled_inputs(const NetworkPoints& points, const RbfNetwork& network) {
  Eigen::MatrixXd x(points.outputs.rows(), points.n_inputs());
  for (Eigen::Index p = 0; p < x.rows(); ++p) {
    x.row(p).head(points.displacements.cols()) = points.displacements.row(points.displacement[p]);
    if (!points.place.empty()) x.row(p).tail(points.places.cols()) = points.places.row(points.place[p]);
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      x(p, k) = (x(p, k) - network.input_center[k]) / network.input_half_range[k];
    }
  }
  return x;
}

inline Eigen::MatrixXd scaled_outputs(const NetworkPoints& points, const RbfNetwork& network) {
  Eigen::MatrixXd y = points.outputs;
  for (Eigen::Index k = 0; k < 3; ++k) {
    y.col(k) = (y.col(k).array() - network.output_center[k]) / network.output_half_range[k];
  }
  return y;
}

/// n x (1 + n_neurons): ones, then exp(-|x - c|^2 / r^2) (11).
inline Eigen::MatrixXd basis(const NetworkPoints& points, const RbfNetwork& network) {
  const Eigen::MatrixXd x = scaled_inputs(points, network);
  Eigen::MatrixXd h = Eigen::MatrixXd::Ones(x.rows(), 1 + network.centers.rows());
  for (Eigen::Index i = 0; i < network.centers.rows(); ++i) {
    for (Eigen::Index p = 0; p < x.rows(); ++p) {
      h(p, 1 + i) = std::exp(-(x.row(p) - network.centers.row(i)).squaredNorm() / (network.spread * network.spread));
    }
  }
  return h;
}

/// (1 + n_neurons) x 3: bias, then weights.
inline Eigen::MatrixXd coefficients(const RbfNetwork& network) {
  Eigen::MatrixXd w(1 + network.weights.rows(), 3);
  w.row(0) = network.bias.transpose();
  w.bottomRows(network.weights.rows()) = network.weights;
  return w;
}

}  // namespace phynness::test
