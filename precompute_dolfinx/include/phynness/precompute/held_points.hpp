// Tools that hold points between nodes: what the coupled form of the runtime is compared with.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// A tool at a point of the surface: movable nodes of one triangle with their barycentric weights (fixed
/// nodes left out: they do not move).
struct PointTool {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  Vec3 displacement_m{};
};

struct HeldPoints {
  Response response;                 ///< force_N is that of the tools; iterations and cutbacks are sums
  int solves = 0;                    ///< equilibria that were solved for it
  std::vector<Vec3> linear_force_N;  ///< what the undeformed body says of the same tools
  Points linear_displacement_m;      ///< n_nodes x 3
};

/// Equilibrium with sum_i w_i q_i = displacement at every tool, q_i what the probe at node i prescribes, and
/// the force at node i the tools' w_i F: the point-constrained problem. Newton's method on q and F; every
/// iterate is a solve with all touched nodes prescribed, from rest in `increments` equal steps.
/// @throws Error as ProbeSolver::touch
HeldPoints hold_points(ProbeSolver& solver, const std::vector<PointTool>& tools, int increments);

}  // namespace phynness
