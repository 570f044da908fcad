#include "probe_records.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <phynness/precompute/precompute.hpp>

namespace phynness {
namespace {

double length_of(const Vec3& v) { return to_eigen(v).norm(); }
double distance(const Vec3& a, const Vec3& b) { return (to_eigen(a) - to_eigen(b)).norm(); }

bool is_counted(const std::vector<char>& counts, Eigen::Index i) {
  return counts.empty() || counts[static_cast<std::size_t>(i)] != 0;
}

}  // namespace

void LargestResponse::add(const Vec3& force, const Points& u, const std::vector<char>& counts, bool flagged) {
  if (flagged && !_only_flagged) return;
  if (!flagged && _only_flagged) *this = {};
  _only_flagged = flagged;
  force_N = std::max(force_N, length_of(force));
  for (Eigen::Index i = 0; i < u.rows(); ++i)
    if (is_counted(counts, i)) displacement_m = std::max(displacement_m, u.row(i).norm());
}

ProbeErrors probe_errors(const ComparedState& c, const LargestResponse& largest, const std::vector<char>& counts) {
  ProbeErrors errors;
  errors.force = errors.force_own = std::numeric_limits<double>::quiet_NaN();
  if (largest.force_N > 0) {
    errors.force = distance(c.force, c.force_FE) / largest.force_N;
    errors.force_own = distance(c.force, c.force_FE) / std::max(length_of(c.force_FE), force_floor * largest.force_N);
  }
  for (Eigen::Index i = 0; i < c.u.rows() && largest.displacement_m > 0; ++i)
    if (is_counted(counts, i))
      errors.displacement.push_back((c.u.row(i) - c.u_FE.row(i)).norm() / largest.displacement_m);
  return errors;
}

void add_errors(const std::vector<ComparedState>& compared, const std::vector<char>& counts,
                GroupMeasures<std::vector<double>>& samples) {
  LargestResponse largest;
  for (const auto& c : compared) largest.add(c.force_FE, c.u_FE, counts);
  for (const auto& c : compared) {
    const auto errors = probe_errors(c, largest, counts);
    if (largest.force_N > 0) samples.force.push_back(errors.force);
    if (c.u.rows() == 0) continue;
    samples.displacement.insert(samples.displacement.end(), errors.displacement.begin(), errors.displacement.end());
    double error2 = 0, norm2 = 0;
    for (Eigen::Index i = 0; i < c.u.rows(); ++i) {
      if (!is_counted(counts, i)) continue;
      const double size = c.u_FE.row(i).norm(), error = (c.u.row(i) - c.u_FE.row(i)).norm();
      norm2 += size * size;
      error2 += error * error;
    }
    if (norm2 > 0) samples.field_l2.push_back(std::sqrt(error2 / norm2));
  }
}

std::pair<std::vector<std::optional<Vec3>>, Points> linear_response(const ProbeSolver& solver, const Model& model,
                                                                    const std::vector<Vec3>& d) {
  const Eigen::Map<const Eigen::VectorXd> q(d.front().data(), 3 * std::ssize(d));
  const Eigen::VectorXd f = solver.rest().stiffness_N_per_m * q, u = solver.rest().sensitivity * q;
  std::vector<std::optional<Vec3>> force_N;
  for (Eigen::Index t = 0; t < f.size(); t += 3) force_N.emplace_back(Vec3{f[t], f[t + 1], f[t + 2]});
  return {force_N, Eigen::Map<const Points>(u.data(), u.size() / 3, 3)(model.output, Eigen::all)};
}

void add_ranks(const SolverSession& session, std::vector<std::int64_t*> counts, AnswerCounts& answers) {
  counts.insert(counts.end(),
                {&answers.unsettled, &answers.outside, &answers.near, &answers.bounded, &answers.covered});
  for (auto* count : counts) *count = session.total(*count);
  for (auto* values : {&answers.bounds_N, &answers.forces_N}) *values = session.gather(*values);
}

ProbeRecords::ProbeRecords(const NamedOrgan& model)
    : _model(model), _error_sum(model.model().output.size()), _error_count(model.model().output.size()) {}

void ProbeRecords::add(std::size_t entry, double weight, const NodeProbes& probes) {
  for (std::size_t group = 0; group < probes.states.size(); ++group) add_group(probes, group);
  add_to_range(static_cast<double>(entry), weight, probes);
  if (!probes.curve.depth_m.empty()) _curves.add({static_cast<double>(probes.node)}, probes.curve);
}

void ProbeRecords::add_group(const NodeProbes& probes, std::size_t group) {
  const auto mean = [](const std::vector<double>& errors) {
    return std::accumulate(errors.begin(), errors.end(), 0.0) / std::max(1.0, static_cast<double>(errors.size()));
  };
  LargestResponse largest;
  for (const auto& state : probes.states[group]) largest.add(state.force_FE, state.u_FE, probes.counts);
  for (const auto& state : probes.states[group]) {
    const auto response = _model.blend({probes.node}, {state.d});
    auto model = probe_errors({*response.force_N[0], state.force_FE, response.displacement_m, state.u_FE}, largest,
                              probes.counts);
    if (!(largest.force_N > 0)) model.force = 0;
    _records.add(
        {static_cast<double>(probes.node), group > 0 ? 1.0 : 0.0},
        {probes.node, group > 0, state.d, state.force_FE, *response.force_N[0], model.force, mean(model.displacement)});
    if (group > 0 || response.displacement_m.rows() == 0) continue;
    auto error = model.displacement.begin();
    for (std::size_t o = 0; o < probes.counts.size() && error != model.displacement.end(); ++o) {
      if (!probes.counts[o]) continue;
      _error_sum[o] += *error++;
      _error_count[o] += 1;
    }
    const auto position = std::ranges::upper_bound(_shown, model.force, std::greater{}, &ShownState::force_error);
    _shown.insert(position, {probes.node, state.d, model.force, state.u_FE, response.displacement_m});
    if (_shown.size() > most_shown_states) _shown.pop_back();
  }
}

void ProbeRecords::add_to_range(double entry, double weight, const NodeProbes& probes) {
  LargestResponse in_range, all;
  for (const auto& probe : probes.range) {
    if (probe.status != Status::converged) continue;
    const auto& state = probes.state(probe);
    all.add(state.force_FE, state.u_FE, probes.counts);
    if (probe.beyond) continue;
    Vec3 force;
    in_range.add(state.force_FE, state.u_FE, probes.counts,
                 is_flagged(int{_model.organ().hold(tool_at(probes.node, probe.d), force)}));
  }
  for (const auto& probe : probes.range) {
    ProbeResult result;
    result.node = probes.node;
    result.weight = weight;
    result.displacement_m = probe.d;
    result.beyond = probe.beyond;
    result.status = probe.status;
    result.reached_m = probe.reached_m;
    const auto response = _model.blend({probes.node}, {probe.d});
    result.flagged = is_flagged(response.status);
    if (_model.has_bounds())
      result.bound_N = _model.error_bound(probes.node, probe.d).value_or(std::numeric_limits<double>::infinity());
    result.largest_N = in_range.force_N;
    if (result.solved()) {
      const auto& state = probes.state(probe);
      const auto& largest = probe.beyond ? all : in_range;
      result.error_N = distance(*response.force_N[0], state.force_FE);
      result.force_N = length_of(state.force_FE);
      result.model = probe_errors({*response.force_N[0], state.force_FE, response.displacement_m, state.u_FE}, largest,
                                  probes.counts);
      result.linear =
          probe_errors({state.force_linear, state.force_FE, state.u_linear, state.u_FE}, largest, probes.counts);
    }
    _results.add({entry}, result);
  }
}

std::vector<ShownState> ProbeRecords::gathered_states(const SolverSession& session) const {
  OrderedRows<ShownState> rows;
  for (const auto& state : _shown) rows.add({-state.force_error, static_cast<double>(state.node)}, state);
  auto states = rows.gathered(session);
  states.resize(std::min(states.size(), most_shown_states));
  return states;
}

void ProbeRecords::finish(const SolverSession& session, double range_m, ValidationReport& report) const {
  report.records = _records.gathered(session);
  report.curves = _curves.gathered(session);
  report.shown = gathered_states(session);
  report.to_range = errors_to_range(_results.gathered(session), range_m);
  const auto n = std::ssize(_error_sum);
  const auto of_ranks = [&](const std::vector<double>& own) -> Eigen::VectorXd {
    const auto all = session.gather(own);
    return Eigen::Map<const Eigen::MatrixXd>(all.data(), n, n > 0 ? std::ssize(all) / n : 0).rowwise().sum();
  };
  const Eigen::VectorXd sums = of_ranks(_error_sum), means = sums.cwiseQuotient(of_ranks(_error_count).cwiseMax(1));
  report.output_error.assign(means.begin(), means.end());
}

}  // namespace phynness
