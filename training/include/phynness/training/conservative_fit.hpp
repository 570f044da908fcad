// Fits the forces of one active node by a network that is the gradient of a potential (formats/model.md, family modal).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness {

/// Forces of converged increments, one per row.
struct ForceStates {
  Eigen::Matrix<double, Eigen::Dynamic, 3> x;      ///< displacement over max_displacement_m
  Eigen::Matrix<double, Eigen::Dynamic, 3> force;  ///< [N]
  std::vector<std::int32_t> row;                   ///< row of TrainingTables::displacements
  std::vector<std::int32_t> direction;             ///< exploratory direction
  /// [N] energy over max_displacement_m, whose gradient is the force; NaN: not known. Empty: none is.
  Eigen::VectorXd energy = {};
};
/// @throws Error (failure) if the force of a converged increment is not finite
ForceStates force_states(const TrainingTables& tables, const std::vector<Ray>& rays);

/// A smaller network with the first of the selected centers, or the full network.
struct ForceLevel {
  ConservativeNetwork network;
  /// Leave-one-out error: mean |model - data| over the states, divided by the largest |data|. Each state is predicted
  /// by the same least squares with the same centers from all other states.
  double left_out_error = 0;
};

struct ConservativeFit {
  ConservativeNetwork network;
  /// Mean |model - data| over the states, divided by the largest |data|.
  double training_error = 0;
  /// The same with one direction at a time left out, by interpolation of all others, for the best shape.
  double left_out_error = 0;
  /// Largest sum of the absolute terms over the largest force. Its decimal logarithm is the number of digits lost by
  /// cancellation.
  double cancellation = 0;
  std::vector<ForceLevel> levels;  ///< smallest first, the last is the full network; empty with a single level
};

/// Largest share of centers in a third of the equations: half as many as states, two thirds where energies are known.
/// With a center for nearly every state the network is arbitrary between the states, and K is undetermined.
inline constexpr double largest_center_share = 0.5;

/// With a larger cancellation, energy would not be conserved in float32; then a smaller shape is used.
inline constexpr double largest_cancellation = 1e3;

/// Centers are selected from the states by orthogonal least squares: the next center is the state whose three columns
/// explain most of the remaining forces and energies, with larger weights for small forces (Chen, Cowan & Grant 1991,
/// doi 10.1109/72.80341). Generalized cross-validation determines their number (Golub, Heath & Wahba 1979,
/// doi 10.1080/00401706.1979.10489751). The shape is the candidate with the smallest left-out error. Coefficients are
/// rounded to float32. Cost: about 5 (3 n)^2 m flops for n states and m centers, and (3 n)^3 / 3 for each tried shape.
/// @param max_displacement_m  R
/// @param max_centers  largest number of centers, which is also limited by largest_center_share
/// @param n_levels     if greater than 1, further networks with half, a quarter, ... of the centers and the same shape
///                     are fitted in the same way
/// @pre there is at least one state, and all values are finite
ConservativeFit fit_conservative(const ForceStates& states, double max_displacement_m, int max_centers,
                                 int n_levels = 1);

/// Force [N] at x = d / R by simple loops, as the reference for other implementations.
Eigen::Vector3d evaluate_force(const ConservativeNetwork& network, const Points& displacements,
                               double max_displacement_m, const Eigen::Vector3d& x);

}  // namespace phynness
