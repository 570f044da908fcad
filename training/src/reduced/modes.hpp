// Proper orthogonal modes in a metric.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

namespace phynness::reduced {

/// M X for columns X, with a symmetric M that is positive definite on them.
using Metric = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

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

}  // namespace phynness::reduced
