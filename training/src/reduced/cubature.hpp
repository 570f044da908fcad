// Few points with nonnegative weights whose sum stands for the sum over many (Farhat, Chapman, Avery 2015, doi
// 10.1002/nme.4820).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace phynness::reduced {

struct Cubature {
  std::vector<std::int32_t> points;  ///< ascending
  Eigen::VectorXd weights;           ///< positive
  Eigen::VectorXd left;              ///< wanted - parts weights
};

/// Nonnegative least squares, parts weights = wanted, by the active set method of Lawson and Hanson, which ends with
/// `count` points. The choice of points is made in float, the weights are solved in double.
/// @param parts   a column for each point
/// @param chosen  called with the number of chosen points
/// @param threads at least 1; the result is bitwise independent of it
Cubature nonnegative_weights(const Eigen::MatrixXf& parts, const Eigen::VectorXd& wanted, Eigen::Index count,
                             int threads, const std::function<void(Eigen::Index)>& chosen);

}  // namespace phynness::reduced
