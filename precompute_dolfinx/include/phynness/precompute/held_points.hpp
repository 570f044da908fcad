// Finite element solves with tools that hold points between nodes, for comparison with the coupled tools of the
// runtime.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// A tool at a point of the surface: nodes of its triangle with their barycentric weights; those of weight 0 may be
/// left out. Fixed nodes count for where the point is, and are not moved.
struct PointTool {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  Vec3 displacement_m{};
};

struct HeldPoints {
  Response response;                 ///< force_N belongs to the tools; iterations and cutbacks are sums over all solves
  int solves = 0;                    ///< number of solved equilibria
  std::vector<Vec3> linear_force_N;  ///< forces of the same tools by the linearized body at rest
  Points linear_displacement_m;      ///< n_nodes x 3
};

/// Solves the point-constrained problem: equilibrium with sum_i w_i q_i = displacement at every tool, where q_i is the
/// displacement prescribed at node i, and with the force w_i F of each tool at node i. Method: Newton's method for q
/// and F. Every iterate is a solve from rest with all touched nodes prescribed, in `increments` equal steps.
/// In a scene of patches every tool is a patch around its point instead (touched_nodes), which one solve gives.
/// @param tangents  of patches: dF/dd in the response
/// @throws Error as ProbeSolver::touch; (input) if all nodes of a tool are fixed
HeldPoints hold_points(ProbeSolver& solver, const std::vector<PointTool>& tools, int increments, bool tangents = false);

}  // namespace phynness
