// What an interpolant of all other data says of data left out, without solving again for each group.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace phynness {

/// Rows of the data that belong together.
using RowGroups = std::vector<std::vector<Eigen::Index>>;

/// The rows of a matrix that `which` names, in that order.
Eigen::MatrixXd rows_of(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& which);

/// One group for each run of states with equal numbers, of their direction for instance: `per_state` rows a
/// state, after `first_row` rows that are never left out.
RowGroups groups_of_equal(const std::vector<std::int32_t>& numbers, Eigen::Index per_state, Eigen::Index first_row);

/// Errors (n x columns of values) of the interpolant kernel w + tail c = values, tail^T w = 0, at each group
/// of rows when that group is left out; zero at rows in no group. With A the matrix of that system and w =
/// (A^-1 v), the errors of group g are [(A^-1)_gg]^-1 w_g (Rippa 1999, doi 10.1023/A:1018975909870, for
/// groups). Groups that the tail needs to be determined get the size of the values instead.
/// @param kernel  n x n, symmetric, definite on the null space of tail^T
Eigen::MatrixXd left_out(const Eigen::MatrixXd& kernel, const Eigen::MatrixXd& tail, const Eigen::MatrixXd& values,
                         const RowGroups& groups);

/// The same of a damped least squares, whose columns are given: errors at each group of rows when that group
/// is left out. With Q of an orthogonal factorization of the columns, damping included, they are
/// [I - Q_g Q_g^T]^-1 times what the fit of all leaves of the group. Groups without which the columns are not
/// determined get the size of the values instead.
/// @param damped  n rows of data, and below them those of the damping
/// @param rest    n x columns: values less fit
Eigen::MatrixXd left_out_of_fit(const Eigen::MatrixXd& damped, const Eigen::MatrixXd& rest,
                                const Eigen::MatrixXd& values, const RowGroups& groups);

/// The same from orthonormal columns q, n rows. @param q  of the data alone
Eigen::MatrixXd left_out_of_projection(const Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>& q,
                                       const Eigen::MatrixXd& rest, const Eigen::MatrixXd& values,
                                       const RowGroups& groups);

}  // namespace phynness
