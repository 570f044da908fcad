// Fresh solves that models are measured on.
#pragma once

#include <array>
#include <functional>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/validation.hpp>
#include <vector>

namespace phynness {

/// One solved probe, and the linear predictor's word on it, at the output nodes of the model.
struct ProbedState {
  Vec3 d{}, force_FE{}, force_linear{};
  Points u_FE, u_linear;
  Eigen::MatrixXd fields_FE,
      fields_linear;  ///< n_output x n_fields, those of the model; linear: linear theory's
};

struct NodeProbes {
  std::int32_t node = 0;
  std::vector<char> counts;                        ///< per output node: 0 where the tool moves it itself
  std::array<std::vector<ProbedState>, 2> states;  ///< inside and beyond the trained range
  ForceCurve curve;                                ///< of the first ray
  std::int64_t failed = 0, increments = 0;
  double cpu_s = 0;  ///< of following the rays; turning to the node left out
};

/// What one rank did.
struct SolvedShare {
  std::int64_t rays = 0;
  bool stopped = false;
};

/// Solves this rank's share of the plan; `take` gets each entry of it with its position. Where `stop` says so
/// it ends after the ray at hand, and the last entry taken has fewer probes than planned.
SolvedShare solve_probes(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                         const std::vector<NodePlan>& plan,
                         const std::function<void(std::int64_t, std::int64_t)>& progress,
                         const std::function<bool()>& stop, const std::function<void(std::size_t, NodeProbes&&)>& take);

/// The model's own errors on those probes.
PredictorErrors model_errors(const LoadedModel& model, const std::vector<NodeProbes>& probes);
/// Those of the linear predictor.
PredictorErrors linear_errors(const std::vector<NodeProbes>& probes);

}  // namespace phynness
