// A body that is solved, trained and evaluated in memory, by default the demo's liver.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

#include "models/disturbed_data.hpp"

namespace phynness::extremes {

struct ModelBody {
  Scene scene;
  study::StudyData data;  ///< all active nodes are in `probed`
  const Mesh& mesh() const { return data.header.mesh; }
};

/// Solves every ray of a scene of the distribution.
/// @param depth_m      depth; 0: of the scene
/// @param most_active  number of active nodes, selected at random; 0: all
ModelBody solve_body(const std::string& scene_name, double depth_m = 0, int most_active = 0);
/// [training] of the scene with another family.
TrainingSpec training_of(const Scene& scene, Family family);
LoadedModel train_on(const study::StudyData& data, const TrainingSpec& spec);

/// A prediction for one probe of a node, and the finite element solution.
struct Compared {
  Eigen::Vector3d force{0, 0, 0}, force_FE{0, 0, 0};
  Points u, u_FE;  ///< at the output nodes
};
/// Errors (17) over the probes of some nodes; the probes of each node form one group.
class Errors {
 public:
  /// @param without  position of the touched node among the output nodes
  void add_node(const std::vector<Compared>& probes, Eigen::Index without);
  ErrorStatistics force() const { return ErrorStatistics::of(_force); }
  ErrorStatistics displacement() const { return ErrorStatistics::of(_displacement); }

 private:
  std::vector<double> _force, _displacement;
};

/// Rows of all nodes that are output nodes.
Points at_output(const Points& all, const std::vector<std::int32_t>& output);
/// "0.41  1.2 12.3": mean, p95, max in per cent.
std::string percent(const ErrorStatistics& e);

}  // namespace phynness::extremes
