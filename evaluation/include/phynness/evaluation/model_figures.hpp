// How well a model repeats the database that it was trained on, beside linear responses of the same data, and how fast
// the runtime answers on this machine.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/database.hpp>
#include <phynness/formats/described.hpp>
#include <vector>

namespace phynness {

/// Means of (17) over the converged increments of some nodes, as fractions; displacements over the output nodes that
/// the tool does not move itself. 0 if there is nothing to compare. Linear responses are fitted to the first increments
/// of a node.
struct DatabaseErrors {
  double force = 0, force_linear = 0;
  std::optional<double> displacement, displacement_linear;
  std::int64_t nodes = 0;  ///< compared; none where fewer than three directions converged
  PHYNNESS_FIGURES(force, force_linear, displacement, displacement_linear, nodes)
};

/// @param most_nodes  nodes that are compared, spread evenly over the active ones
/// @throws Error if the model is not of the database's nodes
DatabaseErrors errors_on_database(const LoadedModel& model, const Database& database, std::size_t most_nodes = 12);

/// A mean error that matters, and is larger than that of linear responses.
inline bool is_worse_than_linear(double model, double linear) { return model > linear && model > 1e-3; }

/// Median times of one call of the runtime in one thread; deformations of prepared nodes (phn_prepare).
struct RuntimeSpeed {
  double force_us = 0, deformation_us = 0;
  double field_us = 0;  ///< of one scalar field; 0: the model has no fields
};
RuntimeSpeed measure_speed(const LoadedModel& model);

}  // namespace phynness
