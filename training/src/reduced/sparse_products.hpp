// Products of sparse and dense matrices, compiled in one file as those of dense_products.hpp.
#pragma once

#include <Eigen/SparseCore>

namespace phynness {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// a b
Eigen::MatrixXd product(const Sparse& a, const Eigen::Ref<const Eigen::MatrixXd>& b);
/// a^T b
Eigen::MatrixXd transposed_product(const Sparse& a, const Eigen::Ref<const Eigen::MatrixXd>& b);
/// a x
Eigen::VectorXd applied(const Sparse& a, const Eigen::Ref<const Eigen::VectorXd>& x);
/// a^T x
Eigen::VectorXd transposed_applied(const Sparse& a, const Eigen::Ref<const Eigen::VectorXd>& x);

}  // namespace phynness
