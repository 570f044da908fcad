// Statistics of the bounds of the force's error (formats/model.md, Bounds; docs/decisions/error-bounds.md).
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/validation/bound_coverage.hpp>
#include <phynness/validation/named_organ.hpp>
#include <vector>

namespace phynness {

/// One solved state of a random ray inside the trained range.
struct BoundState {
  std::int32_t node = 0;  ///< index into Model::nodes
  Vec3 direction{};
  double depth_m = 0, error_N = 0, force_N = 0;
};

/// Predictors of errors, from the trained states of each node.
struct BoundPredictors {
  std::vector<double> largest_N;  ///< largest force of the trained states of each node
  std::vector<std::vector<double>>
      compression;  ///< log(-log J) for each node and displacement, with the smallest J of all cells
};
/// @throws Error (input) if the model was not trained on this database
BoundPredictors bound_predictors(const Model& model, const Database& database);

/// Adds bounds that cover the share `coverage` of similar states.
/// @throws Error (input) if there are too few states
Model add_bounds(Model model, const BoundPredictors& predictors, const std::vector<BoundState>& states,
                 std::int64_t n_rays, double coverage);

/// The errors of given states with the bounds of a model.
std::vector<BoundedError> bounded_errors(const NamedOrgan& bounded, const std::vector<BoundState>& states);

}  // namespace phynness
