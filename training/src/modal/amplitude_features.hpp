// What amplitudes of modes are fitted with, shared by their fit and the choice of their centers.
#pragma once

#include <Eigen/Core>
#include <phynness/training/modal_fit.hpp>

namespace phynness {

/// Displacements of these rows of the table, over the largest.
Eigen::MatrixX3d scaled_rows(const TrainingTables& tables, const std::vector<std::int32_t>& rows);

/// n x (centers + 3), of a field + 9: the amplitudes' features at each x.
/// @param degree  of a field near rest; 0: a displacement
Eigen::MatrixXd features(const Eigen::MatrixX3d& x, const Eigen::MatrixX3d& centers, double shape, int degree = 0);

}  // namespace phynness
