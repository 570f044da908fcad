// The sample model of examples/, with round tools.
#pragma once

#include <algorithm>
#include <phynness/formats/model.hpp>
#include <phynness/meshes/probe_points.hpp>

#include "../model_dir.hpp"

namespace phynness::test {

/// The sample model with its mesh, as if its tools were round, and with bounds between nodes. Errors do not matter
/// here, but the responses are those of a soft body, and the surface is that of an organ of which a part is probed.
/// @param spacing_m  > 0: only nodes at this distance are probed; others lie between them
inline Model sample_of_round_tools(double spacing_m) {
  ModelDir dir = read_model_dir(PHYNNESS_SOURCE_DIR "/examples/model");
  Model& model = dir.model;
  for (ActiveNodeModel& node : model.nodes) node.moves_mean = true;
  model.bounds.at(0).between = {0.3, 0.6, 0.2, 0.15};
  if (!(spacing_m > 0)) return model;
  std::vector<std::int32_t> active;
  for (const ActiveNodeModel& node : model.nodes) active.push_back(node.node);
  const auto kept = spread_nodes(dir.mesh.nodes, dir.mesh.surface, active, spacing_m, 0);
  std::erase_if(model.nodes,
                [&](const auto& node) { return !std::binary_search(kept.begin(), kept.end(), node.node); });
  cover_surface(model, dir.mesh, 3 * spacing_m);
  return model;
}

}  // namespace phynness::test
