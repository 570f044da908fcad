// The parametric study of the paper's Figure 9, automated: which spread serves points that were not trained
// on.
#pragma once

#include <functional>
#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness {

/// Candidates, a factor sqrt(2) apart, in scaled inputs.
std::vector<double> deformation_spread_candidates();
std::vector<double> force_spread_candidates();

/// Mean of |network - data| over the points, divided by the largest |data| (equation (17), per network).
double mean_relative_error(const RbfNetwork& network, const NetworkPoints& points);

/// One node that takes part in a search.
struct SearchNode {
  std::int32_t node = 0;
  TouchedNodes prescribed;
  std::vector<Ray> rays;
};

/// The candidate with the smallest mean, over the nodes, of the error on held-out points: for forces every
/// fifth of the shuffled increments; for deformations up to 3,000 points beside the training samples, as many
/// as the paper tests with. Deterministic: depends on the data, `spec.seed` and the neuron numbers only.
/// @return 0 if no node has enough points
double search_force_spread(const TrainingTables& tables, const std::vector<SearchNode>& nodes,
                           const TrainingSpec& spec);
double search_deformation_spread(const TrainingTables& tables, const std::vector<SearchNode>& nodes,
                                 const TrainingSpec& spec);

}  // namespace phynness
