// From the rays of one active node of a linear body to its stiffness and three unit responses.
#pragma once

#include <phynness/training/node_training.hpp>

namespace phynness {

/// A scene whose responses miss proportionality by more than this is refused: it is not linear. Responses of
/// a linear law stay below 1e-7 (displacements stored as float32) and about the solver's relative tolerance
/// (the rest).
inline constexpr double linear_tolerance = 1e-4;

/// Displacements within this angle (as a sine) of one plane do not determine three unit responses: the
/// rounding of the data would be magnified by its inverse.
inline constexpr double independence_threshold = 1e-2;

/// How well proportionality holds, each the largest over the increments and each without unit.
struct LinearQuality {
  double displacement_residual = 0;  ///< |u - sum d_k U_k| at the worst output node over the increment's largest |u|
  double force_residual = 0;         ///< |f - K d| / |f|, K symmetrized
  double energy_residual = 0;        ///< |E - d.K d / 2| / E; rays without energies are left out
  double asymmetry = 0;              ///< |K - K^T| / |K| (Frobenius) before K is symmetrized
};

struct LinearTraining {
  bool trained = false;  ///< false: no increment converged
  ActiveNodeModel model;
  LinearQuality quality;
};

/// Least squares over all converged increments: f = K d, u = d_x U_x + d_y U_y + d_z U_z. In a linear body
/// all of them say the same, so the fit is exact to the rounding of the data. Responses are rounded to
/// float32 where the displacements behind them were: the digits beyond are noise and make model.txt half as
/// long again. At prescribed nodes the response is the weight, exactly.
/// @param node  mesh node number; `point` its coordinates [m]; `rays` one per direction, in order
/// @throws Error  input: converged increments in fewer than three independent directions, or responses that
/// are not
///                linear (`linear_tolerance`); failure: values that are not finite
LinearTraining train_linear_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                                 const TouchedNodes& prescribed, const std::vector<Ray>& rays);

}  // namespace phynness
