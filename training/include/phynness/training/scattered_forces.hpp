// Trains a model on the forces of one place at any displacements, from another program or from measurements.
#pragma once

#include <phynness/formats/model.hpp>
#include <phynness/training/conservative_fit.hpp>
#include <string>

namespace phynness {

struct ScatteredFit {
  Model model;
  std::int64_t fitted = 0;  ///< displacements that the fit uses, at most `max_training_states`
  ConservativeFit fit;      ///< its figures; its network is that of the model
};

/// A model of family modal with one active node, 0, at the origin, which has forces and no deformation. Displacements
/// need not lie on rays: each counts for the nearest of the 26 exploratory directions, whose trained depth is the
/// largest of them. If they are more than `max_training_states`, those of each direction are thinned evenly.
/// @param displacements_m, forces_N  n x 3, with n >= 6 different displacements; force that holds the displacement
/// @param max_centers  as fit_conservative()
/// @throws Error (input) if the numbers of rows differ, a number is not finite, there are too few displacements, a
/// force at rest is more than 5 % of the largest one, or the forces point against the displacements on the whole
ScatteredFit fit_scattered(const Points& displacements_m, const Points& forces_N, int max_centers,
                           const std::string& title);

}  // namespace phynness
