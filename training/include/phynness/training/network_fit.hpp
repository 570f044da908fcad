// Fits a Gaussian network to a set of points by orthogonal least squares (paper, section 2.2).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <vector>

namespace phynness {

/// Training points whose inputs are pairs (displacement, place): point p has the inputs
/// [displacements.row(displacement[p]), places.row(place[p])]. Without places (0 columns, `place` empty) the inputs are
/// displacements only. With pairs a basis column is a product of two short tables of exponentials.
struct NetworkPoints {
  Eigen::MatrixXd displacements;           ///< n_displacements x k, k >= 1
  Eigen::MatrixXd places;                  ///< n_places x l, l >= 0
  std::vector<std::int32_t> displacement;  ///< n: rows of `displacements`; sorted input is fastest
  std::vector<std::int32_t> place;         ///< n: rows of `places`, or empty
  Eigen::MatrixXd outputs;                 ///< n x 3

  Eigen::Index n_inputs() const { return displacements.cols() + places.cols(); }
  std::size_t size() const { return displacement.size(); }
};

struct FitOptions {
  int max_neurons = 200;
  double spread = 0.75;   ///< r of (11), in scaled inputs
  double target_mse = 0;  ///< growth stops when the MSE (14) of the scaled outputs is at most this
  int n_levels = 1;  ///< if greater than 1: weights are also fitted for the first half, quarter, ... of the neurons
  /// Group of each point, ascending. The points of a group are left out together for NetworkLevel::left_out_error;
  /// empty: no estimate.
  std::vector<std::int32_t> group = {};
};

/// The first neurons of a network with separately fitted weights.
struct NetworkLevel {
  FirstNeurons neurons;
  /// Mean |network - data| over the points, divided by the largest |data|. Each point is predicted by the same least
  /// squares with the same centers from all groups except its own.
  double left_out_error = 0;
};

struct NetworkFit {
  RbfNetwork network;                 ///< centers, weights and transforms complete
  std::vector<std::int32_t> centers;  ///< selected training points in order of growth, without repeats
  /// MSE (14) after 0, 1, 2, ... neurons: mean of the squared scaled error over points and outputs.
  std::vector<double> mse;
  std::vector<NetworkLevel> levels;  ///< smallest first, the last is the full network; empty with a single level
};

/// A candidate is skipped if orthogonalization leaves less than this fraction of its basis column. Rounding errors are
/// amplified in the weights by at most about its inverse, which double precision allows.
inline constexpr double dependence_threshold = 1e-6;

/// This number of successive dependent candidates ends the growth, because the spread is too wide for more neurons.
inline constexpr int max_dependent_in_a_row = 20;

/// Fits one network. Inputs and outputs are centered and scaled to [-1, 1] per column over the given points. The bias
/// is the first column. The next center is the remaining point with the largest squared error summed over the outputs
/// (the first of equals). Its column is orthogonalized by blocked modified Gram-Schmidt. The weights follow from
/// back-substitution with one step of iterative refinement. Cost: about 4 n m^2 / 2 flops and 8 n m bytes for n points
/// and m neurons.
/// @pre there is at least one point, all values are finite, spread > 0
NetworkFit fit_network(const NetworkPoints& points, const FitOptions& options);

/// Evaluates (11)-(12) at unscaled inputs (n_inputs) by simple loops, as the reference for other implementations.
Eigen::Vector3d evaluate(const RbfNetwork& network, const Eigen::VectorXd& inputs);

}  // namespace phynness
