// Probes and their errors: computed on every rank, gathered at the end.
#pragma once

#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <phynness/validation/probed_states.hpp>
#include <phynness/validation/tools.hpp>

#include "body_predictions.hpp"
#include "packed.hpp"

namespace phynness {

/// Judged probes; their order is the place in the plan.
using JudgedRows = OrderedRows<JudgedProbe>;

/// Largest finite element responses, by which errors are divided: of states without a warning, which include no crushed
/// cells; of all of them if each has a warning.
struct LargestResponse {
  double force_N = 0, displacement_m = 0;
  /// @param counts  per output node: 0 if it does not count; empty: all count
  void take(const Vec3& force, const Points& u, const std::vector<char>& counts, bool flagged = false);

 private:
  bool _only_flagged = true;
};

/// A prediction and the finite element solution at one displacement. @param u  without rows: the predictor has forces
/// only
struct Compared {
  Vec3 force{}, force_FE{};
  Points u, u_FE;  ///< n_output x 3
};
ProbeErrors probe_errors(const Compared& compared, const LargestResponse& largest, const std::vector<char>& counts);

/// Adds the errors (17) of all displacements of one place.
void add_errors(const std::vector<Compared>& compared, const std::vector<char>& counts,
                GroupMeasures<std::vector<double>>& samples);

template <template <class> class Measures, class A, class B, class Work>
void member_by_member(Measures<A>& a, const Measures<B>& b, const Work& work) {
  std::vector<A*> of_a;
  Measures<A>::describe(a, [&](const auto&, A& value, const char* = nullptr) { of_a.push_back(&value); });
  auto at = of_a.begin();
  Measures<B>::describe(b, [&](const auto&, const B& value, const char* = nullptr) { work(**at++, value); });
}

/// Of the samples of all ranks, on rank 0. Collective.
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

/// Forces of the undeformed body and displacements of its output nodes. @param d  of each tool that touches it
std::pair<std::vector<std::optional<Vec3>>, Points> linear_response(const ProbeSolver& solver, const Model& model,
                                                                    const std::vector<Vec3>& d);

/// Adds up those of all ranks, on every rank. Collective.
void add_ranks(const SolverSession& session, std::vector<std::int64_t*> counts, AnswerCounts& answers);

/// What comparisons of tools with finite elements have in common.
class ToolComparison {
 public:
  /// @param body  null: none
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
  std::optional<BodyPredictions> _body;
};

class ProbeRecords {
 public:
  explicit ProbeRecords(const NamedOrgan& model);
  /// @param entry  position in the plan. @param weight  of the node
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
  JudgedRows _judged;
  std::vector<ShownState> _shown;                ///< by descending error
  std::vector<double> _error_sum, _error_count;  ///< per output node
};

}  // namespace phynness
