// Features of the amplitudes of modes, used by their fit and by the selection of their centers.
#pragma once

#include <Eigen/Core>
#include <phynness/training/modal_fit.hpp>

namespace phynness {

/// Displacements of these rows of the table, divided by the largest displacement.
Eigen::MatrixX3d scaled_rows(const TrainingTables& tables, const std::vector<std::int32_t>& rows);

/// Features of the amplitudes at each x: n x (centers + 3), for a field n x (centers + 9).
/// @param degree  degree of a field near rest; 0: a displacement
Eigen::MatrixXd features(const Eigen::MatrixX3d& x, const Eigen::MatrixX3d& centers, double shape, int degree = 0);

}  // namespace phynness
