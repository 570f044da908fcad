#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <phynness/phynness.hpp>
#include <phynness/validation/errors_to_range.hpp>

namespace phynness {

double ProbeResult::depth_m() const { return std::hypot(displacement_m[0], displacement_m[1], displacement_m[2]); }

std::string in_percent(double fraction) {
  if (std::isnan(fraction)) return "-";
  const double value = 100 * fraction;
  if ((value > 0 && value < 0.005) || value >= 99999.5) return fmt::format("{:.0e}", value);
  return value < 9.995   ? fmt::format("{:.2f}", value)
         : value < 99.95 ? fmt::format("{:.1f}", value)
                         : fmt::format("{:.0f}", value);
}

bool is_flagged(int status) { return (status & ~PHN_WARNING_INCOMPLETE) != PHN_OK; }

namespace {

PredictionErrors statistics(const std::vector<const ProbeResult*>& probes, ProbeErrors ProbeResult::*predictor) {
  std::vector<double> force, displacement;
  std::size_t wrong = 0;
  for (const auto* probe : probes) {
    const ProbeErrors& errors = probe->*predictor;
    displacement.insert(displacement.end(), errors.displacement.begin(), errors.displacement.end());
    if (std::isnan(errors.force)) continue;
    force.push_back(errors.force);
    wrong += errors.force_own > wrong_fraction;
  }
  const double share = force.empty() ? 0 : static_cast<double>(wrong) / static_cast<double>(force.size());
  return {ErrorStatistics::of(std::move(force)), ErrorStatistics::of(std::move(displacement)), share};
}

double mean_or_nan(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : ErrorStatistics::of(values).mean;
}

ErrorsOfNode errors_of_node(std::int32_t node, const std::vector<const ProbeResult*>& probes) {
  std::vector<double> force, displacement;
  for (const auto* probe : probes) {
    if (!probe->solved()) continue;
    if (!std::isnan(probe->model.force)) force.push_back(probe->model.force);
    displacement.insert(displacement.end(), probe->model.displacement.begin(), probe->model.displacement.end());
  }
  return {node, mean_or_nan(force), mean_or_nan(displacement)};
}

std::optional<WorstNode> worst_node(const std::vector<ProbeResult>& probes, bool flagged) {
  const ProbeResult* worst = nullptr;
  const auto counts = [&](const ProbeResult& p) { return p.solved() && p.flagged == flagged; };
  for (const auto& p : probes)
    if (counts(p) && (worst == nullptr || p.error_N > worst->error_N)) worst = &p;
  if (worst == nullptr) return std::nullopt;
  std::vector<double> errors;
  for (const auto& p : probes)
    if (counts(p) && p.node == worst->node) errors.push_back(p.error_N);
  return WorstNode{worst->node, worst->error_N, mean_or_nan(errors), worst->largest_N, flagged};
}

ProbeStatistics statistics_of(const std::vector<ProbeResult>& probes,
                              const std::function<bool(const ProbeResult&)>& is_member) {
  ProbeStatistics result;
  std::vector<const ProbeResult*> solved;
  for (const auto& probe : probes) {
    if (!is_member(probe)) continue;
    ++result.probes;
    if (probe.solved()) solved.push_back(&probe);
  }
  result.solved = std::ssize(solved);
  result.share = probes.empty() ? 0 : static_cast<double>(result.probes) / static_cast<double>(probes.size());
  result.model = statistics(solved, &ProbeResult::model);
  result.linear = statistics(solved, &ProbeResult::linear);
  return result;
}

void add_bounds(const std::vector<ProbeResult>& in_range, ErrorsToRange& result) {
  if (std::ranges::all_of(in_range, [](const auto& p) { return std::isnan(p.bound_N); })) return;
  std::vector<BoundedError> errors;
  std::vector<double> bounds, forces;
  for (const auto& p : in_range)
    if (p.solved() && p.bound_N < std::numeric_limits<double>::infinity()) {
      errors.push_back({p.depth_m(), p.error_N, p.bound_N, p.weight});
      bounds.push_back(p.bound_N);
      forces.push_back(p.force_N);
    }
  result.bounds = coverage_of(errors, result.range_m);
  result.median_bound_N = ErrorStatistics::of(std::move(bounds)).median;
  result.median_force_N = ErrorStatistics::of(std::move(forces)).median;
}

}  // namespace

ErrorsByWarning errors_by_warning(const std::vector<ProbeResult>& probes) {
  ErrorsByWarning result;
  result.all = statistics_of(probes, [](const ProbeResult&) { return true; });
  result.unflagged = statistics_of(probes, [](const ProbeResult& p) { return !p.flagged; });
  result.flagged = statistics_of(probes, [](const ProbeResult& p) { return p.flagged; });
  std::ranges::copy_if(probes, std::back_inserter(result.unreached), [](const ProbeResult& p) { return !p.solved(); });
  return result;
}

ErrorsToRange errors_to_range(const std::vector<ProbeResult>& probes, double range_m) {
  std::vector<ProbeResult> in_range, beyond;
  for (const auto& probe : probes) (probe.beyond ? beyond : in_range).push_back(probe);
  ErrorsToRange result;
  static_cast<ErrorsByWarning&>(result) = errors_by_warning(in_range);
  result.range_m = range_m;
  result.beyond = statistics_of(beyond, [](const ProbeResult&) { return true; });
  std::map<std::int32_t, std::vector<const ProbeResult*>> by_node;
  for (const auto& probe : in_range) by_node[probe.node].push_back(&probe);
  for (const auto& [node, of_node] : by_node) result.nodes.push_back(errors_of_node(node, of_node));
  result.worst = worst_node(in_range, false);
  if (!result.worst) result.worst = worst_node(in_range, true);
  add_bounds(in_range, result);
  return result;
}

}  // namespace phynness
