#include "range_records.hpp"

#include <algorithm>
#include <limits>
#include <phynness/precompute/precompute.hpp>

namespace phynness {
namespace {

/// Order, node, displacement, beyond, flagged, status, reached depth, four errors of force, error, largest force,
/// force, weight, bound, two counts.
constexpr std::size_t judged_head = 20;

double length_of(const Vec3& v) { return to_eigen(v).norm(); }

bool counts_at(const std::vector<char>& counts, Eigen::Index i) {
  return counts.empty() || counts[static_cast<std::size_t>(i)] != 0;
}

JudgedProbe read_judged(const double* row) {
  JudgedProbe p;
  p.node = static_cast<std::int32_t>(row[1]);
  p.displacement_m = {row[2], row[3], row[4]};
  p.beyond = row[5] > 0;
  p.flagged = row[6] > 0;
  p.status = static_cast<Status>(static_cast<int>(row[7]));
  p.reached_m = row[8];
  const auto n_model = static_cast<std::ptrdiff_t>(row[18]), n_linear = static_cast<std::ptrdiff_t>(row[19]);
  const double* u = row + judged_head;
  p.model = {row[9], row[10], {u, u + n_model}};
  p.linear = {row[11], row[12], {u + n_model, u + n_model + n_linear}};
  p.error_N = row[13];
  p.largest_N = row[14];
  p.force_N = row[15];
  p.weight = row[16];
  p.bound_N = row[17];
  return p;
}

}  // namespace

void JudgedRows::add(std::int64_t order, const JudgedProbe& p) {
  const auto& d = p.displacement_m;
  const auto &u = p.model.displacement, &linear = p.linear.displacement;
  _rows.insert(_rows.end(), {static_cast<double>(order),
                             static_cast<double>(p.node),
                             d[0],
                             d[1],
                             d[2],
                             p.beyond ? 1.0 : 0.0,
                             p.flagged ? 1.0 : 0.0,
                             static_cast<double>(p.status),
                             p.reached_m,
                             p.model.force,
                             p.model.force_own,
                             p.linear.force,
                             p.linear.force_own,
                             p.error_N,
                             p.largest_N,
                             p.force_N,
                             p.weight,
                             p.bound_N,
                             static_cast<double>(u.size()),
                             static_cast<double>(linear.size())});
  _rows.insert(_rows.end(), u.begin(), u.end());
  _rows.insert(_rows.end(), linear.begin(), linear.end());
}

std::vector<JudgedProbe> JudgedRows::gathered(const SolverSession& session) const {
  const auto rows = session.gather(_rows);
  std::vector<std::pair<double, JudgedProbe>> ordered;
  for (std::size_t at = 0; at + judged_head <= rows.size();) {
    const double* row = rows.data() + at;
    ordered.emplace_back(row[0], read_judged(row));
    at += judged_head + static_cast<std::size_t>(row[18]) + static_cast<std::size_t>(row[19]);
  }
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<JudgedProbe> probes;
  probes.reserve(ordered.size());
  for (auto& [order, probe] : ordered) probes.push_back(std::move(probe));
  return probes;
}

void LargestResponse::take(const Vec3& force, const Points& u, const std::vector<char>& counts) {
  force_N = std::max(force_N, length_of(force));
  for (Eigen::Index i = 0; i < u.rows(); ++i)
    if (counts_at(counts, i)) displacement_m = std::max(displacement_m, u.row(i).norm());
}

ProbeErrors probe_errors(const Vec3& force, const Points& u, const Vec3& force_FE, const Points& u_FE,
                         const LargestResponse& largest, const std::vector<char>& counts) {
  ProbeErrors errors;
  const double off = (to_eigen(force) - to_eigen(force_FE)).norm();
  errors.force = errors.force_own = std::numeric_limits<double>::quiet_NaN();
  if (largest.force_N > 0) {
    errors.force = off / largest.force_N;
    errors.force_own = off / std::max(length_of(force_FE), force_floor * largest.force_N);
  }
  for (Eigen::Index i = 0; i < u.rows() && largest.displacement_m > 0; ++i)
    if (counts_at(counts, i)) errors.displacement.push_back((u.row(i) - u_FE.row(i)).norm() / largest.displacement_m);
  return errors;
}

void RangeRecords::add(std::size_t entry, double weight, const NodeProbes& probes) {
  LargestResponse to_R, all;
  for (const auto& probe : probes.range) {
    if (probe.status != Status::converged) continue;
    const auto& state = probes.state(probe);
    all.take(state.force_FE, state.u_FE, probes.counts);
    if (!probe.beyond) to_R.take(state.force_FE, state.u_FE, probes.counts);
  }
  for (const auto& probe : probes.range) {
    JudgedProbe judged;
    judged.node = probes.node;
    judged.weight = weight;
    judged.displacement_m = probe.d;
    judged.beyond = probe.beyond;
    judged.status = probe.status;
    judged.reached_m = probe.reached_m;
    const auto said = _model.respond({probes.node}, {probe.d});
    judged.flagged = is_flagged(said.status);
    if (_model.has_bounds())
      judged.bound_N = _model.error_bound(probes.node, probe.d).value_or(std::numeric_limits<double>::infinity());
    judged.largest_N = to_R.force_N;
    judged.force_N = length_of(*said.force_N[0]);
    if (judged.solved()) {
      const auto& state = probes.state(probe);
      const auto& largest = probe.beyond ? all : to_R;
      judged.model =
          probe_errors(*said.force_N[0], said.displacement_m, state.force_FE, state.u_FE, largest, probes.counts);
      judged.error_N = (to_eigen(*said.force_N[0]) - to_eigen(state.force_FE)).norm();
      judged.linear =
          probe_errors(state.force_linear, state.u_linear, state.force_FE, state.u_FE, largest, probes.counts);
    }
    _rows.add(static_cast<std::int64_t>(entry), judged);
  }
}

}  // namespace phynness
