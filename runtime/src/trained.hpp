// Distances from the training data of a node: the displacements of its converged increments, and rest.
#pragma once

#include "model.hpp"

namespace PHN_RUNTIME {

/// The largest distance from a displacement inside the trained range to the nearest trained displacement, over
/// max_displacement, sampled at a few hundred directions and four depths; 1 without training data.
/// @param depths  n_directions [m]. @pre directions and displacements are loaded
double fill_distance(const phn_model& model, const double* depths);

/// Bound [N] of the error of the force (formats/model.md, Bounds): in the direction nearest to d, linear between its
/// displacements. @pre node.bound is set; d is inside the trained range
double error_bound(const phn_model& model, const ActiveNode& node, const double* d);

/// Distance from d to the nearest trained displacement, over max_displacement; finite for every finite d.
double trained_distance(const phn_model& model, const ActiveNode& node, const double* d);

}  // namespace PHN_RUNTIME
