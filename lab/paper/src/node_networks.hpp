// The paper's networks of many sizes at one node, and their errors.
#pragma once

#include <phynness/studies/measurements.hpp>
#include <phynness/validation/probed_states.hpp>

#include "node_data.hpp"

namespace phynness::study {

/// Data for training and measuring the networks of a node.
struct NodeUnderStudy {
  const NodeData& data;
  const NodeProbes& probes;
  TouchedNodes touched;
  std::vector<Ray> rays;
  double deformation_spread = 0, force_spread = 0;
};

/// Sets by_neurons, by_spread, by_samples and histograms.
void measure_deformation(const NodeUnderStudy& node, const StudySizes& sizes, NodeMeasurements& out);
/// Sets force_as_paper and force_all.
void measure_forces(const NodeUnderStudy& node, const StudySizes& sizes, NodeMeasurements& out);
/// One force network on all increments.
NetworkFit fit_force(const NodeUnderStudy& node, int neurons);

}  // namespace phynness::study
