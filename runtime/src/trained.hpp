// Where a node was trained: the displacements of its converged increments, and rest.
#pragma once

#include "model.hpp"

namespace PHN_RUNTIME {

/// The largest distance from a place inside the trained range to the nearest trained displacement, over
/// max_displacement: that of a few hundred directions at four depths, or 1 where nothing was trained.
/// @param depths  n_directions [m]. @pre directions and displacements are loaded
double fill_distance(const phn_model& model, const double* depths);

/// Distance from d to the nearest trained displacement, over max_displacement; finite for every finite d.
double trained_distance(const phn_model& model, const ActiveNode& node, const double* d);

}  // namespace PHN_RUNTIME
