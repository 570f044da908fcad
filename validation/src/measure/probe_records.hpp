// Results of probes, which ranks compute separately and gather at the end.
#pragma once

#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <phynness/validation/probed_states.hpp>
#include <phynness/validation/tools.hpp>

#include "body_predictions.hpp"
#include "packed.hpp"

namespace phynness {

/// Results of probes in the order of the plan.
using ProbeResultRows = OrderedRows<ProbeResult>;

/// The largest finite element responses, by which errors are divided: over the states without a warning, or over all
/// states if each has a warning.
struct LargestResponse {
  double force_N = 0, displacement_m = 0;
  /// @param counts  flags of counted output nodes; empty if all are counted
  void add(const Vec3& force, const Points& u, const std::vector<char>& counts, bool flagged = false);

 private:
  bool _only_flagged = true;
};

/// A prediction and the finite element solution at one displacement.
struct ComparedState {
  Vec3 force{}, force_FE{};
  Points u, u_FE;  ///< n_output x 3; u has no rows for a predictor of forces only
};
ProbeErrors probe_errors(const ComparedState& compared, const LargestResponse& largest,
                         const std::vector<char>& counts);

/// Appends the errors (17) of all displacements of one place to the samples.
void add_errors(const std::vector<ComparedState>& compared, const std::vector<char>& counts,
                GroupMeasures<std::vector<double>>& samples);

template <template <class> class Measures, class A, class B, class Work>
void member_by_member(Measures<A>& a, const Measures<B>& b, const Work& work) {
  std::vector<A*> of_a;
  Measures<A>::describe(a, [&](const auto&, A& value, const char* = nullptr) { of_a.push_back(&value); });
  auto at = of_a.begin();
  Measures<B>::describe(b, [&](const auto&, const B& value, const char* = nullptr) { work(**at++, value); });
}

/// Statistics of the samples of all ranks, on rank 0. Collective.
template <template <class> class Measures>
Measures<ErrorStatistics> statistics(const SolverSession& session, const Measures<std::vector<double>>& samples) {
  Measures<ErrorStatistics> out;
  member_by_member(out, samples, [&](auto& of, const auto& list) { of = ErrorStatistics::of(session.gather(list)); });
  return out;
}

template <template <class> class Measures>
Measures<ErrorStatistics> statistics(const Measures<std::vector<double>>& samples) {
  Measures<ErrorStatistics> out;
  member_by_member(out, samples, [](auto& of, const auto& list) { of = ErrorStatistics::of(list); });
  return out;
}

/// Linear response of the undeformed body: forces, and displacements of output nodes. @param d  displacements of the
/// tools
std::pair<std::vector<std::optional<Vec3>>, Points> linear_response(const ProbeSolver& solver, const Model& model,
                                                                    const std::vector<Vec3>& d);

/// Replaces the counts by their sums over all ranks. Collective.
void add_ranks(const SolverSession& session, std::vector<std::int64_t*> counts, AnswerCounts& answers);

/// The base of comparisons of tools with finite elements.
class ToolComparison {
 public:
  /// @param body  may be null
  ToolComparison(const Scene& scene, const NamedOrgan& model, const NamedOrgan* body, const ShouldStop& stop)
      : _model(model),
        _increments(scene.probe.increments),
        _solver(scene, model.mesh(), {model.model().fixed, {}, model.model().output}) {
    _solver.set_stop(stop);
    if (body) _body.emplace(*body, model, _increments);
  }

 protected:
  const NamedOrgan& _model;
  int _increments;
  ProbeSolver _solver;
  std::optional<BodyPredictor> _body;
};

class ProbeRecords {
 public:
  explicit ProbeRecords(const NamedOrgan& model);
  /// @param entry  position in the plan. @param weight  weight of the node
  void add(std::size_t entry, double weight, const NodeProbes& probes);
  /// Fills `records`, `curves`, `shown`, `output_error` and `to_range` on rank 0. Collective.
  void finish(const SolverSession& session, double range_m, ValidationReport& report) const;

 private:
  void add_group(const NodeProbes& probes, std::size_t group);
  void add_to_range(double entry, double weight, const NodeProbes& probes);
  std::vector<ShownState> gathered_states(const SolverSession& session) const;

  const NamedOrgan& _model;
  OrderedRows<ProbeRecord> _records;
  OrderedRows<ForceCurve> _curves;
  ProbeResultRows _results;
  std::vector<ShownState> _shown;                ///< sorted by descending error
  std::vector<double> _error_sum, _error_count;  ///< per output node
};

}  // namespace phynness
