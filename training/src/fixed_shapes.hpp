// Fits with the kernel's shape given, without the guard that training keeps, and how well conditioned fits
// are: what a study of stability asks and no user needs.
#pragma once

#include <phynness/training/conservative_fit.hpp>
#include <phynness/training/modal_fit.hpp>

namespace phynness {

/// @pre shape > 0
ConservativeFit fit_conservative_of_shape(const ForceStates& states, double max_displacement_m, int max_centers,
                                          double shape);
/// @pre shape > 0
AmplitudeCenters amplitude_centers_of_shape(const TrainingTables& tables, const std::vector<NodeModes>& nodes,
                                            int max_centers, double shape);

/// Condition number of the normal matrix, damping included, that gave the network its coefficients.
double condition_number(const ForceStates& states, const ConservativeNetwork& network);
/// The same of the amplitudes' network of a node.
double condition_number(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node);

}  // namespace phynness
