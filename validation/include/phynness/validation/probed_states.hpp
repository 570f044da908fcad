// New finite element solutions with which models are compared.
#pragma once

#include <array>
#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/validation.hpp>
#include <vector>

namespace phynness {

/// Flags of the output nodes in (17): no tool at `touched` prescribes their displacement.
std::vector<char> counted_nodes(const Model& model, const std::vector<std::int32_t>& touched);

/// A solved probe with the response of the linear predictor, at the output nodes of the model.
struct ProbedState {
  Vec3 d{}, force_FE{}, force_linear{};
  Points u_FE, u_linear;
  Eigen::MatrixXd fields_FE, fields_linear;  ///< n_output x n_fields
};

/// A probe up to the scene's R or beyond it, with or without a solution.
struct RangeProbe {
  Vec3 d{};
  bool beyond = false;
  Status status = Status::not_solved;  ///< converged, or the reason of the end of the ray
  double reached_m = 0;                ///< deepest solved state of the ray
  std::size_t list = 0, at = 0;        ///< position of a converged state: states[list][at], or further[at] if list is 2
};

struct NodeProbes {
  std::int32_t node = 0;
  std::vector<char> counts;                        ///< counted_nodes()
  std::array<std::vector<ProbedState>, 2> states;  ///< inside and outside the trained range
  std::vector<RangeProbe> range;                   ///< probes up to R, if they are planned
  std::vector<ProbedState> further;                ///< states of `range` that are not in `states`
  const ProbedState& state(const RangeProbe& p) const { return p.list < 2 ? states[p.list][p.at] : further[p.at]; }
  ForceCurve curve;  ///< of the first ray
  std::int64_t failed = 0, increments = 0;
  double cpu_s = 0;  ///< CPU time of the rays, without the preparation of the node
};

/// Solves this rank's part of the plan. `on_node` receives each solved entry and its position in the plan. If `stop`
/// returns true, the function ends after the present ray, and the last entry is incomplete.
/// @return number of solved rays of this rank
std::int64_t solve_probes(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const std::vector<NodePlan>& plan, const OnProgress& progress, const ShouldStop& stop,
                          const std::function<void(std::size_t, NodeProbes&&)>& on_node);

/// Errors of the model for these probes.
PredictorErrors model_errors(const NamedOrgan& model, const std::vector<NodeProbes>& probes);
/// Errors of the linear predictor for these probes.
PredictorErrors linear_errors(const std::vector<NodeProbes>& probes);

}  // namespace phynness
