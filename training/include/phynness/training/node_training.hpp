// From the rays of one active node to its two networks. No file access: arrays in, ActiveNodeModel out.
#pragma once

#include <cstdint>
#include <phynness/formats/database.hpp>
#include <phynness/formats/tool.hpp>
#include <phynness/training/network_fit.hpp>
#include <vector>

namespace phynness {

/// A network with nearly as many neurons as points follows the noise between them: 150 force neurons on 156
/// points over-fit where 60 to 100 did not (DESIGN, section 4).
inline constexpr double largest_neuron_share = 0.6;

/// What all active nodes of a database share.
struct TrainingTables {
  Points displacements;  ///< n_directions * n_increments x 3 [m], row direction * n_increments + increment
  std::int32_t n_increments = 0;
  std::vector<std::int32_t> output;  ///< mesh node numbers, ascending
  Points output_points;              ///< n_output x 3 [m]
  std::vector<double> magnitudes_m;  ///< n_increments
  bool float64 = false;              ///< displacements were stored as float64
};
TrainingTables training_tables(const DatabaseHeader& header);

/// Row (direction * n_increments + increment) of every converged increment, ascending.
std::vector<std::int32_t> converged_increments(const TrainingTables& tables, const std::vector<Ray>& rays);

/// Everything about an active node but its response: probe, trained depths, directions that stopped short.
ActiveNodeModel describe_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                              const TouchedNodes& prescribed, const std::vector<Ray>& rays);

/// Points of the force network: one per converged increment. `rays` is one per direction, in order.
/// @throws Error (failure) if a converged increment holds a value that is not finite
NetworkPoints force_points(const TrainingTables& tables, const std::vector<Ray>& rays);

/// Points of the deformation network: `samples` of all (converged increment, output node not prescribed),
/// drawn uniformly without replacement by a generator that depends on `seed` and `node` only; all of them if
/// there are fewer.
/// @param held_out  if not null, filled with `n_held_out` further points of the same draw
NetworkPoints deformation_points(const TrainingTables& tables, const std::vector<Ray>& rays,
                                 const TouchedNodes& prescribed, std::int32_t node, int samples, std::uint64_t seed,
                                 NetworkPoints* held_out = nullptr, int n_held_out = 0);

/// Neurons that `n_points` points can carry, at most `wanted`.
int capped_neurons(int wanted, std::size_t n_points);

struct NodeTraining {
  bool trained = false;  ///< false: no increment converged
  ActiveNodeModel model;
  NetworkFit force, deformation;  ///< the fits behind the model, for reports and tests
};

/// @param node    mesh node number; `point` its coordinates [m]
/// @param spec    with both spreads > 0
/// @param estimate_errors  of levels; costs about as much as the training itself
NodeTraining train_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                        const TouchedNodes& prescribed, const std::vector<Ray>& rays, const TrainingSpec& spec,
                        bool estimate_errors = true);

}  // namespace phynness
