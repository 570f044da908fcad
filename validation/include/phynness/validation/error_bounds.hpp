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

/// Properties of the trained states of a model's nodes that predict errors.
struct BoundPredictors {
  std::vector<double> largest_N;           ///< of each node: force of its trained states
  std::vector<std::vector<double>> crush;  ///< of each node and displacement: log(-log J), J of the most crushed cell
};
/// @throws Error (input) if the model was not trained on this database
BoundPredictors bound_predictors(const Model& model, const Database& database);

/// The model with bounds that hold for the share `coverage` of states like these.
/// @throws Error (input) if there are too few states
Model add_bounds(Model model, const BoundPredictors& predictors, const std::vector<BoundState>& states,
                 std::int64_t n_rays, double coverage);

/// The bounds of a model at given states.
std::vector<BoundedError> bounded_errors(const NamedOrgan& bounded, const std::vector<BoundState>& states);

}  // namespace phynness
