// The baseline: orthogonal least squares as a textbook prints it, one column at a time.
#pragma once

#include <phynness/training/network_fit.hpp>

namespace phynness::bench {

/// Same growth and stopping rule as fit_network; every basis column from n exponentials, plain modified
/// Gram-Schmidt.
/// @param inputs   n x m, scaled
/// @param targets  n x 3, scaled
/// @return mean squared error of the trained network (14)
double textbook_training(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& targets, int neurons, double spread);

}  // namespace phynness::bench
