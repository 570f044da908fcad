// Trains the two networks of one active node on its rays, without file access. And the search for the spread with the
// smallest error at points that are not used for training, as in the study of the paper's Figure 9.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/training/network_fit.hpp>
#include <vector>

namespace phynness {

/// Largest number of neurons as a fraction of the points. A network with nearly as many neurons as points over-fits:
/// 150 force neurons on 156 points did, 60 to 100 did not.
inline constexpr double largest_neuron_share = 0.6;

/// Data that are common to all active nodes of a database.
struct TrainingTables {
  Points displacements;  ///< n_directions * n_increments x 3 [m], row direction * n_increments + increment
  std::int32_t n_increments = 0;
  std::vector<std::int32_t> output;  ///< mesh node numbers, ascending
  Points output_points;              ///< n_output x 3 [m]
  std::vector<double> magnitudes_m;  ///< n_increments
  bool float64 = false;              ///< displacements are stored as float64
};
TrainingTables training_tables(const DatabaseHeader& header);

/// Rows (direction * n_increments + increment) of all converged increments, ascending.
std::vector<std::int32_t> converged_increments(const TrainingTables& tables, const std::vector<Ray>& rays);

/// States of a node that training uses. All fits grow with their number, the dense ones with its cube. 98 directions
/// with 6 increments are not thinned.
inline constexpr std::size_t max_training_states = 600;

/// The converged increments from which a node is trained: all of them, or if they are more than `max_training_states`
/// the same increments of every ray, spread evenly to the full depth, and the deepest of each ray.
struct TrainingStates {
  std::vector<std::int32_t> row;         ///< as converged_increments(), ascending
  std::vector<std::int32_t> increments;  ///< of every ray, ascending; without the deepest ones of shorter rays
};
TrainingStates training_states(const TrainingTables& tables, const std::vector<Ray>& rays);

/// Properties of an active node except its response: probe, trained depths, number of incomplete directions.
ActiveNodeModel describe_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                              const TouchedNodes& tool, const std::vector<Ray>& rays);

/// Points of the force network, one per training state. @param rays  one per direction, in order
/// @throws Error (failure) if a value of a converged increment is not finite
NetworkPoints force_points(const TrainingTables& tables, const std::vector<Ray>& rays);

/// Points of the deformation network: `samples` of all pairs (training state, output node that is not prescribed),
/// drawn uniformly without replacement by a generator that depends on `seed` and `node` only; all pairs if there are
/// fewer.
/// @param held_out  output, `n_held_out` further points of the same draw; may be null
NetworkPoints deformation_points(const TrainingTables& tables, const std::vector<Ray>& rays, const TouchedNodes& tool,
                                 std::int32_t node, int samples, std::uint64_t seed, NetworkPoints* held_out = nullptr,
                                 int n_held_out = 0);

/// The smaller of `wanted` and the largest number of neurons for `n_points` points.
int capped_neurons(int wanted, std::size_t n_points);

struct NodeTraining {
  ActiveNodeModel model;
  NetworkFit force, deformation;  ///< the fits, for reports and tests
};

/// @param node   mesh node number
/// @param point  coordinates of the node [m]
/// @param rays   with a converged increment
/// @param spec   with both spreads > 0
/// @param estimate_errors  estimate the errors of levels, which takes about as long as the training itself
NodeTraining train_node(const TrainingTables& tables, std::int32_t node, const Vec3& point, const TouchedNodes& tool,
                        const std::vector<Ray>& rays, const TrainingSpec& spec, bool estimate_errors);

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
