#include "probe_records.hpp"

#include <algorithm>
#include <phynness/precompute/precompute.hpp>

#include "packed.hpp"
#include "range_records.hpp"

namespace phynness {
ProbeRecords::ProbeRecords(const LoadedModel& model)
    : _model(model), _error_sum(model.model().output.size()), _error_count(model.model().output.size()) {}

void ProbeRecords::add(const NodeProbes& probes) {
  for (std::size_t group = 0; group < probes.states.size(); ++group) add_group(probes, group);
  if (!probes.curve.depth_m.empty()) pack(_curves, probes.curve);
}

void ProbeRecords::add_group(const NodeProbes& probes, std::size_t group) {
  LargestResponse largest;
  for (const auto& state : probes.states[group]) largest.take(state.force_FE, state.u_FE, probes.counts);
  for (const auto& state : probes.states[group]) {
    const auto said = _model.respond({probes.node}, {state.d});
    const Vec3 force = *said.force_N[0];
    double error = 0, error_linear = 0, n = 0;
    for (Eigen::Index i = 0; i < state.u_FE.rows() && largest.displacement_m > 0 && said.displacement_m.rows() > 0;
         ++i) {
      const auto o = static_cast<std::size_t>(i);
      if (!probes.counts[o]) continue;
      const double here = (said.displacement_m.row(i) - state.u_FE.row(i)).norm() / largest.displacement_m;
      error += here;
      error_linear += (state.u_linear.row(i) - state.u_FE.row(i)).norm() / largest.displacement_m;
      n += 1;
      if (group > 0) continue;
      _error_sum[o] += here;
      _error_count[o] += 1;
    }
    const double scale = largest.force_N > 0 ? 1 / largest.force_N : 0;
    const auto off = [&](const Vec3& f) { return scale * (to_eigen(f) - to_eigen(state.force_FE)).norm(); };
    pack(_rows, ProbeRecord{probes.node, group > 0, state.d, state.force_FE, force, off(force), off(state.force_linear),
                            n > 0 ? error / n : 0, n > 0 ? error_linear / n : 0});
    if (group == 0 && said.displacement_m.rows() > 0)
      keep({probes.node, state.d, off(force), state.u_FE, said.displacement_m});
  }
}

void ProbeRecords::keep(ShownState&& state) {
  const auto before = [](const ShownState& a, const ShownState& b) { return a.force_error > b.force_error; };
  _shown.insert(std::upper_bound(_shown.begin(), _shown.end(), state, before), std::move(state));
  if (_shown.size() > most_shown_states) _shown.pop_back();
}

std::vector<ShownState> ProbeRecords::gathered_states(const SolverSession& session) const {
  std::vector<double> rows;
  for (const auto& state : _shown) pack(rows, state);
  auto states = unpacked<ShownState>(session.gather(rows));
  std::stable_sort(states.begin(), states.end(), [](const auto& a, const auto& b) {
    return std::pair(-a.force_error, a.node) < std::pair(-b.force_error, b.node);
  });
  states.resize(std::min(states.size(), most_shown_states));
  return states;
}

void ProbeRecords::finish(const SolverSession& session, ValidationReport& report) const {
  const auto sums = session.gather(_error_sum), counts = session.gather(_error_count);
  report.records = unpacked<ProbeRecord>(session.gather(_rows));
  std::stable_sort(report.records.begin(), report.records.end(), [](const auto& a, const auto& b) {
    return std::pair(a.node, a.outside) < std::pair(b.node, b.outside);
  });
  report.curves = unpacked<ForceCurve>(session.gather(_curves));
  std::sort(report.curves.begin(), report.curves.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  report.shown = gathered_states(session);
  const std::size_t n_output = _error_sum.size();
  report.output_error.assign(n_output, 0);
  std::vector<double> total(n_output, 0);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    report.output_error[i % n_output] += sums[i];
    total[i % n_output] += counts[i];
  }
  for (std::size_t i = 0; i < n_output; ++i)
    if (total[i] > 0) report.output_error[i] /= total[i];
}

}  // namespace phynness
