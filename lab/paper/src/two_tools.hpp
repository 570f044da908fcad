// Two tools (the paper's Figure 15): weights (15)-(16) and coupled tools compared with solves with two prescribed
// nodes.
#pragma once

#include <phynness/precompute/probe_solver.hpp>
#include <phynness/studies/measurements.hpp>
#include <phynness/validation/named_organ.hpp>
#include <random>

namespace phynness::study {

/// A random pair: two nodes, two of the exploratory directions, and the ratio of the depths.
struct PairDraw {
  std::int32_t a = 0, b = 0;
  Vec3 first{}, second{};  ///< displacements per metre of the deeper tool's depth
};
PairDraw draw_pair(const Model& model, std::mt19937_64& random);

/// Solves both displacements for the depths `depths_m` of the deeper tool.
ToolPair measure_pair(ProbeSolver& solver, const PairDraw& pair, const std::vector<double>& depths_m,
                      const NamedOrgan& networks, const NamedOrgan& ours);

}  // namespace phynness::study
