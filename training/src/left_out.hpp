// Errors of an interpolant or a least squares fit at left-out data, without a separate solve for each group.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace phynness {

/// Groups of rows of the data.
using RowGroups = std::vector<std::vector<Eigen::Index>>;

/// One group for each run of states with equal numbers, such as the number of their direction. Each state has
/// `per_state` rows, which begin at `first_row`; rows before it are never left out.
RowGroups groups_of_equal(const std::vector<std::int32_t>& numbers, Eigen::Index per_state, Eigen::Index first_row);

/// Errors (n x columns of values) of the interpolant kernel w + tail c = values, tail^T w = 0, at each group of rows
/// when this group is left out; zero at rows without a group. With the matrix A of this system and w = A^-1 v, the
/// errors of group g are [(A^-1)_gg]^-1 w_g (Rippa 1999, doi 10.1023/A:1018975909870, extended to groups). For a group
/// without which the tail is not determined, the errors are set to the values.
/// @param kernel  n x n, symmetric, definite on the null space of tail^T
Eigen::MatrixXd left_out(const Eigen::MatrixXd& kernel, const Eigen::MatrixXd& tail, const Eigen::MatrixXd& values,
                         const RowGroups& groups);

/// The same for damped least squares with given columns. With Q of an orthogonal factorization of the columns,
/// including damping, the errors of a left-out group g are [I - Q_g Q_g^T]^-1 times its residuals in the fit of all
/// rows. For a group without which the columns are not determined, the errors are set to the values.
/// @param damped  n rows of data, followed by the rows of the damping
/// @param rest    n x columns: values minus fit
Eigen::MatrixXd left_out_of_fit(const Eigen::MatrixXd& damped, const Eigen::MatrixXd& rest,
                                const Eigen::MatrixXd& values, const RowGroups& groups);

/// The same from orthonormal columns. @param q  n rows of data, without those of the damping
Eigen::MatrixXd left_out_of_projection(const Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>& q,
                                       const Eigen::MatrixXd& rest, const Eigen::MatrixXd& values,
                                       const RowGroups& groups);

}  // namespace phynness
