// How well a model repeats the database that it was trained on, beside linear responses of the same data.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/database.hpp>

namespace phynness {

/// Means of (17) over the converged increments of some nodes, as fractions; displacements over the output nodes that
/// the tool does not move itself. 0 if there is nothing to compare.
struct DatabaseErrors {
  double force = 0, displacement = 0;                ///< of the model
  double force_linear = 0, displacement_linear = 0;  ///< of linear responses, fitted to the first increments of a node
  std::int64_t n_nodes = 0;                          ///< compared; none where fewer than three directions converged
  bool has_displacement = false;
};

/// @param most_nodes  nodes that are compared, spread evenly over the active ones
/// @throws Error if the model is not of the database's nodes
DatabaseErrors errors_on_database(const LoadedModel& model, const Database& database, std::size_t most_nodes = 12);

/// A mean error that matters, and is larger than that of linear responses.
inline bool is_worse_than_linear(double model, double linear) { return model > linear && model > 1e-3; }

}  // namespace phynness
