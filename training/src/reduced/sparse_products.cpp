#include "sparse_products.hpp"

namespace phynness {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd product(const Sparse& a, const Eigen::Ref<const MatrixXd>& b) { return a * b; }

MatrixXd transposed_product(const Sparse& a, const Eigen::Ref<const MatrixXd>& b) { return a.transpose() * b; }

VectorXd applied(const Sparse& a, const Eigen::Ref<const VectorXd>& x) { return a * x; }

VectorXd transposed_applied(const Sparse& a, const Eigen::Ref<const VectorXd>& x) { return a.transpose() * x; }

}  // namespace phynness
