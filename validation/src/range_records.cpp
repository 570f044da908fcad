#include "range_records.hpp"

#include <algorithm>
#include <limits>
#include <phynness/precompute/precompute.hpp>

#include "packed.hpp"

namespace phynness {
namespace {

double length_of(const Vec3& v) { return to_eigen(v).norm(); }

bool counts_at(const std::vector<char>& counts, Eigen::Index i) {
  return counts.empty() || counts[static_cast<std::size_t>(i)] != 0;
}

/// A probe and its place in the order.
struct Ordered {
  std::int64_t order = 0;
  JudgedProbe probe;
  static void members(auto& o, auto&& each) { each(o.order, o.probe); }
};

}  // namespace

void JudgedRows::add(std::int64_t order, const JudgedProbe& probe) { pack(_rows, Ordered{order, probe}); }

std::vector<JudgedProbe> JudgedRows::gathered(const SolverSession& session) const {
  auto ordered = unpacked<Ordered>(session.gather(_rows));
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.order < b.order; });
  std::vector<JudgedProbe> probes;
  probes.reserve(ordered.size());
  for (auto& [order, probe] : ordered) probes.push_back(std::move(probe));
  return probes;
}

void LargestResponse::take(const Vec3& force, const Points& u, const std::vector<char>& counts, bool flagged) {
  if (flagged && !_only_flagged) return;
  if (!flagged && _only_flagged) *this = {};
  _only_flagged = flagged;
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
    if (probe.beyond) continue;
    Vec3 force;
    to_R.take(state.force_FE, state.u_FE, probes.counts,
              is_flagged(int{_model.data().force(probes.node, probe.d, force)}));
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
