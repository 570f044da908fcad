// Several tools at a time, solved by the finite elements of a database: a reduced body has modes of such fields, and is
// compared with others.
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

/// Tools from rest to a state, in equal increments of their displacements.
struct SolvedTools {
  std::vector<phn_tool> tools;
  std::vector<Vec3> force_N;           ///< per tool, at the end
  std::vector<Points> displacement_m;  ///< of each increment, n_nodes x 3
  double weight = 1;                   ///< density of tools at any points over that of those drawn
  static void members(auto& s, auto&& each) { each(s.tools, s.force_N, s.displacement_m, s.weight); }
};

/// States of two tools and of three, at different probed points drawn at random, to half of the depth in random
/// directions, of a hemisphere inwards.
struct ToolDraws {
  std::int64_t pairs = 0, triples = 0;
  std::uint64_t seed = 1;  ///< every state has its own random numbers; those of other seeds are independent
  double half_within_m =
      0;  ///< in every second state tools are no farther than this from the first one, if they can be
};
/// Ranks share the work. Collective.
/// @return on rank 0, those that are solved; they do not depend on the number of ranks
std::vector<SolvedTools> solve_several_tools(const SolverSession& session, const DatabaseHeader& header,
                                             const ToolDraws& draws, const OnProgress& progress);

/// 3 n_nodes x all increments: of each field all of its x, then y, then z.
Eigen::MatrixXd fields_of(const std::vector<SolvedTools>& solved);

/// Of errors with weights > 0: each stands for as many as its weight. `n` counts them without.
ErrorStatistics weighted_statistics(std::vector<std::pair<double, double>> errors);

/// Of a body, for tools at any points: the error of the worse tool's force over the largest force of a state.
struct ToolErrors {
  ErrorStatistics pairs, triples, near;  ///< near: two of the tools have springs between them (docs/theory.md)
  std::int64_t unsettled = 0;            ///< states that the body warns of, which count above
  double step_s = 0;                     ///< mean time of a step of Newton's method
  PHYNNESS_FIGURES(pairs, triples, near, unsettled, step_s)
};
ToolErrors tool_errors(const ReducedBody& body, const std::vector<SolvedTools>& solved);

}  // namespace phynness
