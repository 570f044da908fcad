// Fits with a given shape of the kernel, without the limits of training, and condition numbers of fits. Used by the
// study of stability only.
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

/// Condition number of the normal matrix, including damping, from which the coefficients of the network follow.
double condition_number(const ForceStates& states, const ConservativeNetwork& network);
/// The same for the amplitudes of a node.
double condition_number(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node);

}  // namespace phynness
