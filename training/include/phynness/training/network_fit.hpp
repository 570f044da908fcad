// One Gaussian network from one set of points: orthogonal least squares growth (paper, section 2.2).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <vector>

namespace phynness {

/// Training points whose inputs are pairs (displacement, place): point p has the inputs
/// [displacements.row(displacement[p]), places.row(place[p])]. Without places (0 columns, `place` empty) the
/// inputs are the displacements alone. The pairs let a basis column be computed as a product of two short
/// tables of exponentials.
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
  double target_mse = 0;  ///< growth stops as soon as the MSE (14) of the scaled outputs is at or below it
  int n_levels = 1;       ///< more than 1: the first half of the neurons, quarter, ... with weights of their own
  /// Per point, ascending: those of one group are left out together for NetworkLevel::left_out_error; none:
  /// no estimate.
  std::vector<std::int32_t> group = {};
};

/// The first neurons of a network with the weights that serve them best alone.
struct NetworkLevel {
  FirstNeurons neurons;
  /// Mean |network - data| over the points, over the largest |data|, each predicted by the same least
  /// squares, centers given, of all groups but its own.
  double left_out_error = 0;
};

/// Why growth ended.
enum class FitStop { max_neurons, target_mse, all_points_tried, dependent };

struct NetworkFit {
  RbfNetwork network;                 ///< centers, weights and transforms complete
  std::vector<std::int32_t> centers;  ///< training points chosen, in order of growth; no point twice
  /// MSE (14) after 0, 1, 2, ... neurons: mean of the squared scaled error over points and outputs.
  std::vector<double> mse;
  int n_dependent = 0;  ///< candidates skipped because their column was numerically dependent
  /// Largest over smallest diagonal entry of the triangular factor: a lower bound of the condition number of
  /// the basis.
  double diagonal_ratio = 1;
  FitStop stop = FitStop::max_neurons;
  std::vector<NetworkLevel> levels;  ///< smallest first, the last the network itself; none unless asked for
};

/// A candidate is skipped if orthogonalization leaves less than this fraction of its basis column. What
/// survives is amplified by at most about its inverse in the weights, which double precision affords.
inline constexpr double dependence_threshold = 1e-6;

/// So many dependent candidates in a row end the growth: the spread is too wide for more neurons.
inline constexpr int max_dependent_in_a_row = 20;

/// Fits one network. Inputs and outputs are centered and scaled to [-1, 1] per column over the given points;
/// the bias is in from the start; the next center is the point, not yet chosen, with the largest squared
/// error summed over the outputs (the first of equals); its column is orthogonalized by blocked modified
/// Gram-Schmidt; the weights come from back-substitution with one step of iterative refinement. Cost: about 4
/// n m^2 / 2 flops and 8 n m bytes for n points and m neurons.
/// @pre at least one point; all values finite; spread > 0
NetworkFit fit_network(const NetworkPoints& points, const FitOptions& options);

/// Evaluates (11)-(12) at unscaled inputs (n_inputs). Plain loops: the reference that other evaluators are
/// held against.
Eigen::Vector3d evaluate(const RbfNetwork& network, const Eigen::VectorXd& inputs);

}  // namespace phynness
