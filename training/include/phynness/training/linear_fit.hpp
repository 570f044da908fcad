// Fits stiffness and three unit responses to the rays of one active node of a linear body.
#pragma once

#include <phynness/training/node_training.hpp>

namespace phynness {

/// Largest relative deviation from proportionality; with a larger deviation the scene is not linear and is refused. For
/// a linear law displacements (float32) deviate by less than 1e-7 and other values by about the solver's relative
/// tolerance.
inline constexpr double linear_tolerance = 1e-4;

/// Displacements within this angle (as a sine) of a plane do not determine three unit responses, because the rounding
/// of the data would be magnified by its inverse.
inline constexpr double independence_threshold = 1e-2;

/// Relative deviations from proportionality, each the maximum over the increments.
struct LinearQuality {
  double displacement_residual = 0;  ///< |u - sum d_k U_k| at the worst output node over the increment's largest |u|
  double force_residual = 0;         ///< |f - K d| / |f| with the symmetrized K
  double energy_residual = 0;        ///< |E - d.K d / 2| / E; without rays that have no energies
  double asymmetry = 0;              ///< |K - K^T| / |K| (Frobenius) before K is symmetrized
};

struct LinearTraining {
  ActiveNodeModel model;
  LinearQuality quality;
};

/// Least squares over the training states, checked at all converged increments: f = K d, u = d_x U_x + d_y U_y + d_z
/// U_z. For a linear body the fit is exact up to the rounding of the data. Responses are rounded to float32 if the
/// stored displacements are float32, because further digits are noise and would make model.txt longer by half. At
/// prescribed nodes the response is exactly the weight.
/// @param node   mesh node number
/// @param point  coordinates of the node [m]
/// @param rays   one per direction, in order, with a converged increment
/// @throws Error (input) if converged increments do not have three independent directions, or if responses are not
///   linear (`linear_tolerance`); (failure) if a value is not finite
LinearTraining train_linear_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                                 const TouchedNodes& tool, const std::vector<Ray>& rays);

}  // namespace phynness
