#include "probe_records.hpp"

#include <algorithm>
#include <phynness/precompute/precompute.hpp>

namespace phynness {
namespace {

/// Node, group, displacement, two forces, four errors.
constexpr std::size_t row_size = 15, curve_head = 5, curve_point = 4;

Vec3 three(const std::vector<double>& from, std::size_t at) { return {from[at], from[at + 1], from[at + 2]}; }

}  // namespace

ProbeRecords::ProbeRecords(const LoadedModel& model)
    : _model(model), _error_sum(model.model().output.size()), _error_count(model.model().output.size()) {}

void ProbeRecords::add(const NodeProbes& probes) {
  for (std::size_t group = 0; group < probes.states.size(); ++group) add_group(probes, group);
  if (!probes.curve.depth_m.empty()) add_curve(probes.curve);
}

void ProbeRecords::add_group(const NodeProbes& probes, std::size_t group) {
  double largest_force = 0, largest_u = 0;
  for (const auto& state : probes.states[group]) {
    largest_force = std::max(largest_force, to_eigen(state.force_FE).norm());
    for (Eigen::Index i = 0; i < state.u_FE.rows(); ++i)
      if (probes.counts[static_cast<std::size_t>(i)]) largest_u = std::max(largest_u, state.u_FE.row(i).norm());
  }
  for (const auto& state : probes.states[group]) {
    const auto said = _model.respond({probes.node}, {state.d});
    const Vec3 force = *said.force_N[0];
    double error = 0, error_linear = 0, n = 0;
    for (Eigen::Index i = 0; i < state.u_FE.rows() && largest_u > 0 && said.displacement_m.rows() > 0; ++i) {
      const auto o = static_cast<std::size_t>(i);
      if (!probes.counts[o]) continue;
      const double here = (said.displacement_m.row(i) - state.u_FE.row(i)).norm() / largest_u;
      error += here;
      error_linear += (state.u_linear.row(i) - state.u_FE.row(i)).norm() / largest_u;
      n += 1;
      if (group > 0) continue;
      _error_sum[o] += here;
      _error_count[o] += 1;
    }
    _rows.insert(_rows.end(), {static_cast<double>(probes.node), static_cast<double>(group)});
    for (const auto* v : {&state.d, &state.force_FE, &force}) _rows.insert(_rows.end(), v->begin(), v->end());
    const double scale = largest_force > 0 ? 1 / largest_force : 0;
    const auto off = [&](const Vec3& f) { return scale * (to_eigen(f) - to_eigen(state.force_FE)).norm(); };
    _rows.insert(_rows.end(),
                 {off(force), off(state.force_linear), n > 0 ? error / n : 0, n > 0 ? error_linear / n : 0});
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
  const auto n = static_cast<Eigen::Index>(_error_sum.size());
  std::vector<double> rows;
  for (const auto& state : _shown) {
    rows.push_back(state.node);
    rows.insert(rows.end(), state.displacement_m.begin(), state.displacement_m.end());
    rows.push_back(state.force_error);
    for (const Points* u : {&state.finite_elements_m, &state.model_m})
      rows.insert(rows.end(), u->data(), u->data() + 3 * n);
  }
  const auto all = session.gather(rows);
  std::vector<ShownState> states;
  for (auto at = all.data(); at + 5 + 6 * n <= all.data() + all.size(); at += 5 + 6 * n)
    states.push_back({static_cast<std::int32_t>(at[0]),
                      {at[1], at[2], at[3]},
                      at[4],
                      Eigen::Map<const Points>(at + 5, n, 3),
                      Eigen::Map<const Points>(at + 5 + 3 * n, n, 3)});
  std::stable_sort(states.begin(), states.end(), [](const auto& a, const auto& b) {
    return std::pair(-a.force_error, a.node) < std::pair(-b.force_error, b.node);
  });
  states.resize(std::min(states.size(), most_shown_states));
  return states;
}

void ProbeRecords::add_curve(const ForceCurve& curve) {
  _curves.push_back(curve.node);
  _curves.insert(_curves.end(), curve.direction.begin(), curve.direction.end());
  _curves.push_back(static_cast<double>(curve.depth_m.size()));
  for (std::size_t i = 0; i < curve.depth_m.size(); ++i) {
    _curves.push_back(curve.depth_m[i]);
    _curves.insert(_curves.end(), curve.force_N[i].begin(), curve.force_N[i].end());
  }
}

void ProbeRecords::finish(const SolverSession& session, ValidationReport& report) const {
  const auto rows = session.gather(_rows), curves = session.gather(_curves), sums = session.gather(_error_sum),
             counts = session.gather(_error_count);
  for (std::size_t at = 0; at + row_size <= rows.size(); at += row_size)
    report.records.push_back({static_cast<std::int32_t>(rows[at]), rows[at + 1] > 0, three(rows, at + 2),
                              three(rows, at + 5), three(rows, at + 8), rows[at + 11], rows[at + 12], rows[at + 13],
                              rows[at + 14]});
  std::stable_sort(report.records.begin(), report.records.end(), [](const auto& a, const auto& b) {
    return std::pair(a.node, a.outside) < std::pair(b.node, b.outside);
  });
  for (std::size_t at = 0; at + curve_head <= curves.size();) {
    ForceCurve curve{static_cast<std::int32_t>(curves[at]), three(curves, at + 1), {}, {}};
    const auto n = static_cast<std::size_t>(curves[at + 4]);
    at += curve_head;
    for (std::size_t i = 0; i < n; ++i, at += curve_point) {
      curve.depth_m.push_back(curves[at]);
      curve.force_N.push_back(three(curves, at + 1));
    }
    report.curves.push_back(std::move(curve));
  }
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
