#include "left_out.hpp"

#include "dense_products.hpp"
#include "dense_solvers.hpp"

namespace phynness {
namespace {

/// If without a group less than this fraction of a combination of columns remains, the group alone determines this
/// combination, and the remainder is damping.
constexpr double undetermined = 1e-8;

}  // namespace

using Eigen::Index;
using Eigen::MatrixXd;

RowGroups groups_of_equal(const std::vector<std::int32_t>& numbers, Index per_state, Index first_row) {
  RowGroups groups;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i == 0 || numbers[i] != numbers[i - 1]) groups.emplace_back();
    for (Index k = 0; k < per_state; ++k) groups.back().push_back(first_row + per_state * static_cast<Index>(i) + k);
  }
  return groups;
}

MatrixXd left_out(const MatrixXd& kernel, const MatrixXd& tail, const MatrixXd& values, const RowGroups& groups) {
  const Index n = kernel.rows(), m = tail.cols();
  MatrixXd system = MatrixXd::Zero(n + m, n + m);
  system.topLeftCorner(n, n) = kernel;
  system.topRightCorner(n, m) = tail;
  system.bottomLeftCorner(m, n) = tail.transpose();
  const MatrixXd inverse = inverse_of(system);
  const MatrixXd weights = product(inverse.topLeftCorner(n, n), values);
  MatrixXd errors = MatrixXd::Zero(n, values.cols());
  for (const auto& group : groups) {
    MatrixXd error = solve_full_pivoting(inverse(group, group), weights(group, Eigen::all));
    if (!error.allFinite()) error = values(group, Eigen::all);
    for (std::size_t i = 0; i < group.size(); ++i) errors.row(group[i]) = error.row(static_cast<Index>(i));
  }
  return errors;
}

MatrixXd left_out_of_fit(const MatrixXd& damped, const MatrixXd& rest, const MatrixXd& values,
                         const RowGroups& groups) {
  return left_out_of_projection(orthonormal(damped).topRows(rest.rows()), rest, values, groups);
}

MatrixXd left_out_of_projection(const Eigen::Ref<const MatrixXd, 0, Eigen::OuterStride<>>& q, const MatrixXd& rest,
                                const MatrixXd& values, const RowGroups& groups) {
  MatrixXd errors = MatrixXd::Zero(rest.rows(), rest.cols());
  for (const auto& group : groups) {
    const MatrixXd some = q(group, Eigen::all), left = rest(group, Eigen::all);
    // (I - Q Q^T)^-1 = I + Q (I - Q^T Q)^-1 Q^T; the smaller of the two matrices is inverted.
    const bool small_group = some.rows() <= some.cols();
    const MatrixXd gram = small_group ? product_transposed(some, some) : transposed_product(some, some);
    const auto solved = solve_if_invertible(MatrixXd::Identity(gram.rows(), gram.cols()) - gram,
                                            small_group ? left : transposed_product(some, left), undetermined);
    MatrixXd error = values(group, Eigen::all);
    if (solved) error = small_group ? *solved : MatrixXd(left + product(some, *solved));
    for (std::size_t i = 0; i < group.size(); ++i) errors.row(group[i]) = error.row(static_cast<Index>(i));
  }
  return errors;
}

}  // namespace phynness
