// The baseline: textbook orthogonal least squares, one column at a time.
#pragma once

#include <phynness/training/network_fit.hpp>

namespace phynness::bench {

/// The growth and stopping rule of fit_network, with n exponentials for every basis column and plain modified
/// Gram-Schmidt.
/// @param inputs   n x m, scaled
/// @param targets  n x 3, scaled
/// @return mean squared error of the trained network (14)
double textbook_training(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& targets, int neurons, double spread);

}  // namespace phynness::bench
