// How much of the probes up to R of a scene a model has trained.
#pragma once

#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness {

struct TrainedShare {
  double all = 0;               ///< mean over the nodes
  std::vector<double> of_node;  ///< in the order of Model::nodes: mean over the directions of (trained depth / R)^3
};
TrainedShare trained_share(const Model& model);
/// One sentence without a full stop, with the nodes where the share is smallest.
std::string sentence(const TrainedShare& share, const Model& model);

}  // namespace phynness
