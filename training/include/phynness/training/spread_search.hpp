// Search for the spread with the smallest error at points that are not used for training, as in the study of the
// paper's Figure 9.
#pragma once

#include <phynness/training/node_training.hpp>
#include <vector>

namespace phynness {

/// Candidates in scaled inputs, with ratios of sqrt(2).
std::vector<double> deformation_spread_candidates();
std::vector<double> force_spread_candidates();

/// Mean of |network - data| over the points, divided by the largest |data| (equation (17) for one network).
double mean_relative_error(const RbfNetwork& network, const NetworkPoints& points);

/// A node in a search.
struct SearchNode {
  std::int32_t node = 0;
  TouchedNodes tool;
  std::vector<Ray> rays;
};

/// The candidate with the smallest error at held-out points, averaged over the nodes. For forces every fifth of the
/// shuffled increments is held out; for deformations up to 3,000 points in addition to the training samples, as in the
/// paper. The result depends on the data, `spec.seed` and the numbers of neurons only.
/// @return the spread; 0 if no node has enough points
double search_force_spread(const TrainingTables& tables, const std::vector<SearchNode>& nodes,
                           const TrainingSpec& spec);
double search_deformation_spread(const TrainingTables& tables, const std::vector<SearchNode>& nodes,
                                 const TrainingSpec& spec);

}  // namespace phynness
