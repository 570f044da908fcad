// Statistics of the bounds of the force's error (formats/model.md, Bounds; docs/decisions/error-bounds.md).
#pragma once

#include <array>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// One solved state of a random ray inside the trained range.
struct BoundState {
  std::int32_t node = 0;  ///< index into Model::nodes
  Vec3 direction{};
  double depth_m = 0, error_N = 0, force_N = 0;
};

/// How well bounds hold. Shares of states whose error is below the bound.
struct BoundCoverage {
  double all = 0;
  std::array<double, 3> thirds{};    ///< of the depth
  std::array<double, 4> quarters{};  ///< of the nodes, by the mean bound over the node's largest force
  double width = 0;                  ///< mean bound over the best constant bound of the same coverage
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
BoundCoverage coverage_of(const LoadedModel& bounded, const BoundPredictors& predictors,
                          const std::vector<BoundState>& states);

}  // namespace phynness
