// How much of the probes up to R of a scene a model has trained.
#pragma once

#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness {

struct TrainedShare {
  double all = 0;               ///< mean over all requested rays; 1 - EndSummary::share_of_volume() of the database
  std::vector<double> of_node;  ///< in the order of Model::nodes: mean over its rays of part_of_volume()
};
TrainedShare trained_share(const Model& model);
/// One sentence without a full stop, with the nodes where the share is smallest.
std::string sentence(const TrainedShare& share, const Model& model);

}  // namespace phynness
