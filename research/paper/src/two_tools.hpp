// Two tools (the paper's Figure 15): weights (15)-(16) and coupled tools against solves with two held nodes.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/studies/measurements.hpp>
#include <random>

namespace phynness::study {

/// One random pair, drawn from `random`: nodes, two of the exploratory directions, the shallower one's share.
struct PairDraw {
  std::int32_t a = 0, b = 0;
  Vec3 first{}, second{};  ///< displacements per metre of the deeper tool's depth
};
PairDraw draw_pair(const Model& model, std::mt19937_64& random);

/// Follows both displacements through `depths_m` of the deeper tool.
ToolPair measure_pair(ProbeSolver& solver, const PairDraw& pair, const std::vector<double>& depths_m,
                      const LoadedModel& networks, const LoadedModel& ours);

}  // namespace phynness::study
