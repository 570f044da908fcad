#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <phynness/phynness.hpp>
#include <phynness/validation/errors_to_range.hpp>

namespace phynness {

double JudgedProbe::depth_m() const { return std::hypot(displacement_m[0], displacement_m[1], displacement_m[2]); }

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

PredictionErrors statistics(const std::vector<const JudgedProbe*>& probes, ProbeErrors JudgedProbe::*by) {
  std::vector<double> force, displacement;
  std::size_t wrong = 0;
  for (const auto* probe : probes) {
    const ProbeErrors& errors = probe->*by;
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

ErrorsOfNode errors_of_node(std::int32_t node, const std::vector<const JudgedProbe*>& probes) {
  std::vector<double> force, displacement;
  for (const auto* probe : probes) {
    if (!probe->solved()) continue;
    if (!std::isnan(probe->model.force)) force.push_back(probe->model.force);
    displacement.insert(displacement.end(), probe->model.displacement.begin(), probe->model.displacement.end());
  }
  return {node, mean_or_nan(force), mean_or_nan(displacement)};
}

std::optional<WorstNode> worst_node(const std::vector<JudgedProbe>& probes, bool flagged) {
  const JudgedProbe* worst = nullptr;
  const auto counts = [&](const JudgedProbe& p) { return p.solved() && p.flagged == flagged; };
  for (const auto& p : probes)
    if (counts(p) && (worst == nullptr || p.error_N > worst->error_N)) worst = &p;
  if (worst == nullptr) return std::nullopt;
  std::vector<double> errors;
  for (const auto& p : probes)
    if (counts(p) && p.node == worst->node) errors.push_back(p.error_N);
  return WorstNode{worst->node, worst->error_N, mean_or_nan(errors), worst->largest_N, flagged};
}

JudgedErrors judged(const std::vector<JudgedProbe>& probes, const std::function<bool(const JudgedProbe&)>& belongs) {
  JudgedErrors out;
  std::vector<const JudgedProbe*> solved;
  for (const auto& probe : probes) {
    if (!belongs(probe)) continue;
    ++out.probes;
    if (probe.solved()) solved.push_back(&probe);
  }
  out.solved = std::ssize(solved);
  out.share = probes.empty() ? 0 : static_cast<double>(out.probes) / static_cast<double>(probes.size());
  out.model = statistics(solved, &JudgedProbe::model);
  out.linear = statistics(solved, &JudgedProbe::linear);
  return out;
}

std::optional<BoundCoverage> bounds_of(const std::vector<JudgedProbe>& to_R, double range_m) {
  if (std::ranges::all_of(to_R, [](const auto& p) { return std::isnan(p.bound_N); })) return std::nullopt;
  std::vector<BoundedError> errors;
  for (const auto& p : to_R)
    if (p.solved() && p.bound_N < std::numeric_limits<double>::infinity())
      errors.push_back({p.depth_m(), p.error_N, p.bound_N, p.weight});
  return coverage_of(errors, range_m);
}

}  // namespace

ErrorsByWarning errors_by_warning(const std::vector<JudgedProbe>& probes) {
  ErrorsByWarning out;
  out.all = judged(probes, [](const JudgedProbe&) { return true; });
  out.unflagged = judged(probes, [](const JudgedProbe& p) { return !p.flagged; });
  out.flagged = judged(probes, [](const JudgedProbe& p) { return p.flagged; });
  std::ranges::copy_if(probes, std::back_inserter(out.unreached), [](const JudgedProbe& p) { return !p.solved(); });
  return out;
}

ErrorsToRange errors_to_range(const std::vector<JudgedProbe>& probes, double range_m) {
  std::vector<JudgedProbe> to_R, beyond;
  for (const auto& probe : probes) (probe.beyond ? beyond : to_R).push_back(probe);
  ErrorsToRange out;
  static_cast<ErrorsByWarning&>(out) = errors_by_warning(to_R);
  out.range_m = range_m;
  out.beyond = judged(beyond, [](const JudgedProbe&) { return true; });
  std::map<std::int32_t, std::vector<const JudgedProbe*>> by_node;
  for (const auto& probe : to_R) by_node[probe.node].push_back(&probe);
  for (const auto& [node, of_node] : by_node) out.nodes.push_back(errors_of_node(node, of_node));
  out.worst = worst_node(to_R, false);
  if (!out.worst) out.worst = worst_node(to_R, true);
  out.bounds = bounds_of(to_R, range_m);
  return out;
}

}  // namespace phynness
