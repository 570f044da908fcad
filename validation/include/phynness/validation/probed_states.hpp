// New solves with which models are compared.
#pragma once

#include <array>
#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/validation.hpp>
#include <vector>

namespace phynness {

/// 1 for the output nodes that count in (17), which are those whose displacement no tool at `touched` prescribes.
std::vector<char> counted_nodes(const Model& model, const std::vector<std::int32_t>& touched);

/// A solved probe with the response of the linear predictor, at the output nodes of the model.
struct ProbedState {
  Vec3 d{}, force_FE{}, force_linear{};
  Points u_FE, u_linear;
  Eigen::MatrixXd fields_FE, fields_linear;  ///< n_output x n_fields: the fields of the model
};

/// A probe up to the scene's R or beyond it, and whether the finite elements reach it.
struct RangeProbe {
  Vec3 d{};
  bool beyond = false;
  Status status = Status::not_solved;  ///< converged, or why the ray ended
  double reached_m = 0;                ///< deepest solved state of the ray
  std::size_t list = 0, at = 0;        ///< if converged: states[list][at], or further[at] if list is 2
};

struct NodeProbes {
  std::int32_t node = 0;
  std::vector<char> counts;                        ///< per output node: 0 if the tool itself moves it
  std::array<std::vector<ProbedState>, 2> states;  ///< inside and outside the trained range
  std::vector<RangeProbe> range;                   ///< if the plan has probes up to R
  std::vector<ProbedState> further;                ///< states of `range` that are not in `states`
  const ProbedState& state(const RangeProbe& p) const { return p.list < 2 ? states[p.list][p.at] : further[p.at]; }
  ForceCurve curve;  ///< of the first ray
  std::int64_t failed = 0, increments = 0;
  double cpu_s = 0;  ///< of the solves of the rays, without the preparation of the node
};

/// Solves the part of the plan of this rank. `take` receives each solved entry with its position in the plan. If `stop`
/// returns true, solving ends after the present ray; the last entry then has fewer probes than planned.
/// @return number of solved rays of this rank
std::int64_t solve_probes(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const std::vector<NodePlan>& plan, const OnProgress& progress, const ShouldStop& stop,
                          const std::function<void(std::size_t, NodeProbes&&)>& take);

/// Errors of the model for these probes.
PredictorErrors model_errors(const NamedOrgan& model, const std::vector<NodeProbes>& probes);
/// Errors of the linear predictor for these probes.
PredictorErrors linear_errors(const std::vector<NodeProbes>& probes);

}  // namespace phynness
