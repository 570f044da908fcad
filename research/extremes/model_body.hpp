// A body that is solved, trained and evaluated in memory: the demo's liver, unless said otherwise.
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

/// Solves every ray of a shipped scene.
/// @param depth_m    instead of the scene's; 0: the scene's
/// @param most_active  nodes that stay active, drawn; 0: all
ModelBody solve_body(const std::string& scene_name, double depth_m = 0, int most_active = 0);
/// The scene's [training] but for the family.
TrainingSpec training_of(const Scene& scene, Family family);
LoadedModel train_on(const study::StudyData& data, const TrainingSpec& spec);

/// What something says of one probe of a node, and the truth.
struct Compared {
  Eigen::Vector3d force{0, 0, 0}, force_FE{0, 0, 0};
  Points u, u_FE;  ///< at the output nodes
};
/// Errors (17) over the probes of some nodes, those of each node in one group.
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
