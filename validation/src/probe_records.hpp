// Probes and their errors for reports: stored on every rank, gathered at the end.
#pragma once

#include <phynness/validation/probed_states.hpp>

namespace phynness {

class ProbeRecords {
 public:
  explicit ProbeRecords(const LoadedModel& model);
  void add(const NodeProbes& probes);
  /// Fills `records`, `curves`, `shown` and `output_error` on rank 0. Collective.
  void finish(const SolverSession& session, ValidationReport& report) const;

 private:
  void add_group(const NodeProbes& probes, std::size_t group);
  void keep(ShownState&& state);
  std::vector<ShownState> gathered_states(const SolverSession& session) const;

  const LoadedModel& _model;
  std::vector<double> _rows, _curves;            ///< rows of numbers, which ranks can exchange
  std::vector<ShownState> _shown;                ///< by descending error
  std::vector<double> _error_sum, _error_count;  ///< per output node
};

}  // namespace phynness
