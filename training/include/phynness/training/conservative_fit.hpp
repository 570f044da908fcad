// From the forces of one active node to a network that is the gradient of a potential (formats/model.md,
// family modal).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/model.hpp>
#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness {

/// Forces at displacements that converged, one per row.
struct ForceStates {
  Eigen::Matrix<double, Eigen::Dynamic, 3> x;      ///< displacement over max_displacement_m
  Eigen::Matrix<double, Eigen::Dynamic, 3> force;  ///< [N]
  std::vector<std::int32_t> row;                   ///< of TrainingTables::displacements
  std::vector<std::int32_t> direction;             ///< exploratory direction
};
/// @throws Error (failure) if a converged increment holds a force that is not finite
ForceStates force_states(const TrainingTables& tables, const std::vector<Ray>& rays);

/// A smaller network on the first of the centers chosen, or the network itself.
struct ForceLevel {
  ConservativeNetwork network;
  /// Mean |model - data| over the states, over the largest |data|, each state predicted by the same least
  /// squares, centers given, of all others.
  double left_out_error = 0;
};

struct ConservativeFit {
  ConservativeNetwork network;
  /// Mean |model - data| over the states, divided by the largest |data|.
  double training_error = 0;
  /// The same at directions left out one by one, by interpolation of all others, at the shape that predicts
  /// them best.
  double left_out_error = 0;
  /// Largest sum of the sizes of the terms over the largest force: digits lost are its decimal logarithm.
  double cancellation = 0;
  std::vector<ForceLevel> levels;  ///< smallest first, the last the network itself; none unless asked for
};

/// Shapes that a search tries, ascending.
std::vector<double> force_shape_candidates();

/// A network with a center for nearly every state follows what lies between them no more: K could be
/// anything.
inline constexpr double largest_center_share = 0.5;

/// Networks that cancel by more than this lose the conservation of energy in float32: a smaller shape is
/// taken.
inline constexpr double largest_cancellation = 1e3;

/// Centers are states chosen one by one by orthogonal least squares: the next is the one whose three columns
/// explain most of what is left of all forces, small ones counted more (Chen, Cowan & Grant 1991,
/// doi 10.1109/72.80341); of them as many are taken as generalized cross-validation is for (Golub, Heath & Wahba
/// 1979, doi 10.1080/00401706.1979.10489751). The shape is the candidate with the smallest left-out error. Coefficients
/// are rounded to float32. Cost: about 5 (3 n)^2 m flops for n states and m centers, and a third of (3 n)^3 for each
/// shape tried.
/// @param max_displacement_m  R
/// @param max_centers  at most this many, and at most largest_center_share of the states
/// @param n_levels  more than 1: networks of half as many centers each, fitted in the same way, the same shape
/// @pre at least one state, all values finite
ConservativeFit fit_conservative(const ForceStates& states, double max_displacement_m, int max_centers,
                                 int n_levels = 1);

/// Force [N] at x = d / R, by plain loops: the reference that other evaluators are held against.
Eigen::Vector3d evaluate_force(const ConservativeNetwork& network, const Points& displacements,
                               double max_displacement_m, const Eigen::Vector3d& x);

}  // namespace phynness
