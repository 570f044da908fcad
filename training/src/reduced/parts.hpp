// Parts of a reduction: proper orthogonal modes in a metric, the choice of weighted points, stiffness at rest.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <phynness/formats/body.hpp>
#include <vector>

namespace phynness::reduced {

/// M X for columns X, with a symmetric M that is positive definite on them.
using Metric = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

/// The columns of all matrices, which have as many rows.
Eigen::MatrixXd side_by_side(std::vector<Eigen::MatrixXd> matrices, Eigen::Index rows);

/// A basis of the space of the columns, orthonormal in the metric, without what is below rounding.
Eigen::MatrixXd orthonormal_in(const Metric& metric, Eigen::MatrixXd columns);

/// The leading modes of the columns, each with its singular value as length in the metric, as few as leave at most the
/// share `lost` of the columns' squared lengths.
/// @param energy  output: the sum of the columns' squared lengths
Eigen::MatrixXd scaled_modes(const Metric& metric, const Eigen::MatrixXd& columns, double lost, double& energy);

/// The leading modes of many columns, orthonormal in the metric, by iteration of a random subspace (Halko, Martinsson,
/// Tropp 2011, doi 10.1137/090771806).
/// @param count     at most so many
/// @param captured  output: the part of the columns' squared lengths that the modes have
/// @param threads   at least 1; the result is bitwise independent of it
Eigen::MatrixXd leading_modes(const Metric& metric, const Eigen::MatrixXd& columns, Eigen::Index count,
                              std::uint64_t seed, int threads, double& captured);

/// Few points with nonnegative weights whose sum stands for the sum over many (Farhat, Chapman, Avery 2015, doi
/// 10.1002/nme.4820).
struct Cubature {
  std::vector<std::int32_t> points;  ///< ascending
  Eigen::VectorXd weights;           ///< positive
  Eigen::VectorXd residual;          ///< wanted - contributions weights
};

/// Nonnegative least squares, contributions weights = wanted, by the active set method of Lawson and Hanson, which ends
/// with `count` points. The choice of points is made in float, the weights are solved in double.
/// @param contributions  a column for each point
/// @param on_added       called with the number of chosen points
/// @param threads        at least 1; the result is bitwise independent of it
Cubature nonnegative_weights(const Eigen::MatrixXf& contributions, const Eigen::VectorXd& wanted, Eigen::Index count,
                             int threads, const std::function<void(Eigen::Index)>& on_added);

/// Stiffness at rest of a tool alone at each of some nodes [N/m]; the result is bitwise independent of `threads`, which
/// call `on_node` after each node.
std::vector<Eigen::Matrix3d> stiffnesses_at_rest(const ReducedBody& body, const std::vector<std::int32_t>& nodes,
                                                 int threads, const std::function<void()>& on_node);

}  // namespace phynness::reduced
