// Force against depth (the paper's Figure 6) at one node.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

#include "node_networks.hpp"

namespace phynness::study {

/// Displaces the node along the inward normal to beyond the trained range. Sets curves and stiffness_N_per_m.
void measure_curves(ProbeSolver& solver, const NodeUnderStudy& node, const NamedOrgan& ours, const Vec3& inward,
                    double deepest_m, const StudySizes& sizes, NodeMeasurements& out);

}  // namespace phynness::study
