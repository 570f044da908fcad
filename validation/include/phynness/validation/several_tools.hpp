// Finite element solutions for several tools at a time, from which a reduced body gets modes, and with which it is
// compared.
#pragma once

#include <phynness/formats/body.hpp>
#include <phynness/formats/database.hpp>
#include <phynness/formats/progress.hpp>
#include <phynness/phynness.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <utility>
#include <vector>

namespace phynness {

/// A solved state of several tools, reached from rest in equal increments.
struct SolvedTools {
  std::vector<phn_tool> tools;
  std::vector<Vec3> force_N;           ///< per tool, at the end
  std::vector<Points> displacement_m;  ///< of each increment, n_nodes x 3
  double weight = 1;                   ///< ratio of the density of uniform places to the sampling density
  static void members(auto& s, auto&& each) { each(s.tools, s.force_N, s.displacement_m, s.weight); }
};

/// Random states of two and of three tools at different nodes where a body answers without a warning, to half of the
/// depth in random directions (inward ones for a hemisphere).
struct ToolDraws {
  std::int64_t pairs = 0, triples = 0;
  std::uint64_t seed = 1;       ///< states of different seeds are independent
  double half_within_m = 0;     ///< largest distance from the first tool in every second state, where possible
  bool half_at_probed = false;  ///< two of four states have all tools at probed nodes
};
/// The increments of one tool that take as long.
double increments_of(const ToolDraws& draws);
/// Solves random states on all ranks. Collective.
/// @return the solved states on rank 0, independent of the number of ranks
std::vector<SolvedTools> solve_several_tools(const SolverSession& session, const DatabaseHeader& header,
                                             const ToolDraws& draws, const OnProgress& progress);

/// All fields, 3 n_nodes x n_increments; a column has all x, then all y, then all z.
Eigen::MatrixXd fields_of(const std::vector<SolvedTools>& solved);

/// Statistics of errors with weights > 0. `n` is the number of errors.
ErrorStatistics weighted_statistics(std::vector<std::pair<double, double>> errors);

/// Force errors of a body: the largest error of a tool over the largest force of the state.
struct ToolErrors {
  ErrorStatistics pairs, triples, near;  ///< near: two tools are nearer than half a radius
  std::int64_t unsettled = 0;            ///< states with this warning, which are included above
  double step_s = 0;                     ///< mean processor time of a step of Newton's method
  PHYNNESS_FIGURES(pairs, triples, near, unsettled, step_s)
};
ToolErrors tool_errors(const ReducedBody& body, const std::vector<SolvedTools>& solved,
                       const OnProgress& progress = {});

/// Displacements of a body under these tools, at half and at the end of their way: its rows of modes x 2 states.
Eigen::MatrixXd displacements_under(const ReducedBody& body, const std::vector<SolvedTools>& solved);

/// What has to reach a target: the largest of p95, a third of the maximum and 2.5 times the mean of two tools, and half
/// of p95 of three if the scene has as many.
double target_error(const ToolErrors& errors, int tools);
/// The factor by which another body must reduce this error.
inline constexpr double required_improvement = 0.9;
/// Leaves out the tables at rest of a body that misses the target if it is better without them: the energy at rest of
/// parts that turn far is not that of their state (docs/decisions/reduced-body.md).
/// @param errors  of the body, before and after
/// @return whether they were left out
bool leave_out_at_rest(ReducedBody& body, ToolErrors& errors, const std::vector<SolvedTools>& solved, double target,
                       int tools, const OnProgress& progress = {});

}  // namespace phynness
