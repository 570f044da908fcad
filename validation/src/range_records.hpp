// Errors of probes up to the scene's R and beyond it: stored on every rank, gathered at the end.
#pragma once

#include <phynness/validation/errors_to_range.hpp>
#include <phynness/validation/probed_states.hpp>

namespace phynness {

/// Judged probes in rows of numbers, which ranks can exchange.
class JudgedRows {
 public:
  /// @param order  sorts the probes of all ranks
  void add(std::int64_t order, const JudgedProbe& probe);
  /// On rank 0 the probes of all ranks, by order; empty on other ranks. Collective.
  std::vector<JudgedProbe> gathered(const SolverSession& session) const;

 private:
  std::vector<double> _rows;
};

/// Largest finite element responses, by which errors are divided: of states without a warning, which include no crushed
/// cells; of all of them if each has a warning.
struct LargestResponse {
  double force_N = 0, displacement_m = 0;
  /// @param counts  per output node: 0 if it does not count; empty: all count
  void take(const Vec3& force, const Points& u, const std::vector<char>& counts, bool flagged = false);

 private:
  bool _only_flagged = true;
};
/// @param u  prediction; without rows the errors have no displacements
ProbeErrors probe_errors(const Vec3& force, const Points& u, const Vec3& force_FE, const Points& u_FE,
                         const LargestResponse& largest, const std::vector<char>& counts);

class RangeRecords {
 public:
  explicit RangeRecords(const LoadedModel& model) : _model(model) {}
  /// @param entry  position in the plan. @param weight  of the node
  void add(std::size_t entry, double weight, const NodeProbes& probes);
  std::vector<JudgedProbe> gathered(const SolverSession& session) const { return _rows.gathered(session); }

 private:
  const LoadedModel& _model;
  JudgedRows _rows;
};

}  // namespace phynness
