#include "dense_products.hpp"

namespace phynness {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd product(const MatrixView& a, const MatrixView& b) { return a * b; }

MatrixXd transposed_product(const MatrixView& a, const MatrixView& b) { return a.transpose() * b; }

MatrixXd product_transposed(const MatrixView& a, const MatrixView& b) { return a * b.transpose(); }

MatrixXd scaled_transposed_product(double alpha, const MatrixView& a, const MatrixView& b) {
  return alpha * a.transpose() * b;
}

void subtract_product(Eigen::Ref<MatrixXd> c, const MatrixView& a, const MatrixView& b) { c.noalias() -= a * b; }

void subtract_product_transposed(Eigen::Ref<MatrixXd> c, const MatrixView& a, const MatrixView& b) {
  c.noalias() -= a * b.transpose();
}

VectorXd applied(const MatrixView& a, const VectorView& x) { return a * x; }

VectorXd transposed_applied(const MatrixView& a, const VectorView& x) { return a.transpose() * x; }

VectorXd residual_of(VectorXd y, const MatrixView& a, const VectorView& x) {
  y.noalias() -= a * x;
  return y;
}

}  // namespace phynness
