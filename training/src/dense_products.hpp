// Products of dense matrices for several fits. They are compiled in one file, because each type of product takes the
// compiler a second or more.
#pragma once

#include <Eigen/Core>

namespace phynness {

using MatrixView = Eigen::Ref<const Eigen::MatrixXd>;
using VectorView = Eigen::Ref<const Eigen::VectorXd>;

/// a b
Eigen::MatrixXd product(const MatrixView& a, const MatrixView& b);
/// a^T b
Eigen::MatrixXd transposed_product(const MatrixView& a, const MatrixView& b);
/// a b^T
Eigen::MatrixXd product_transposed(const MatrixView& a, const MatrixView& b);
/// alpha a^T b
Eigen::MatrixXd scaled_transposed_product(double alpha, const MatrixView& a, const MatrixView& b);
/// c -= a b. @pre c does not overlap with a or b
void subtract_product(Eigen::Ref<Eigen::MatrixXd> c, const MatrixView& a, const MatrixView& b);
/// c -= a b^T. @pre c does not overlap with a or b
void subtract_product_transposed(Eigen::Ref<Eigen::MatrixXd> c, const MatrixView& a, const MatrixView& b);

/// a x
Eigen::VectorXd applied(const MatrixView& a, const VectorView& x);
/// a^T x
Eigen::VectorXd transposed_applied(const MatrixView& a, const VectorView& x);
/// y - a x, rounded like y -= a x
Eigen::VectorXd residual_of(Eigen::VectorXd y, const MatrixView& a, const VectorView& x);

}  // namespace phynness
