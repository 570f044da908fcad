#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <phynness/phynness.hpp>
#include <phynness/validation/errors_to_range.hpp>

namespace phynness {

double JudgedProbe::depth_m() const { return std::hypot(displacement_m[0], displacement_m[1], displacement_m[2]); }

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
  ErrorsOfNode out;
  out.node = node;
  out.probes = std::ssize(probes);
  std::vector<double> force, displacement;
  for (const auto* probe : probes) {
    out.flagged += probe->flagged;
    if (!probe->solved()) continue;
    ++out.solved;
    if (!std::isnan(probe->model.force)) force.push_back(probe->model.force);
    displacement.insert(displacement.end(), probe->model.displacement.begin(), probe->model.displacement.end());
  }
  out.force = mean_or_nan(force);
  out.displacement = mean_or_nan(displacement);
  out.force_max = force.empty() ? out.force : *std::max_element(force.begin(), force.end());
  return out;
}

std::size_t a_tenth(std::size_t n) { return (n + 9) / 10; }

std::vector<std::int32_t> worst_of(const std::vector<ErrorsOfNode>& nodes) {
  std::vector<std::pair<double, std::int32_t>> by_error;
  for (const auto& node : nodes)
    if (!std::isnan(node.force)) by_error.emplace_back(-node.force, node.node);
  std::sort(by_error.begin(), by_error.end());
  by_error.resize(std::min(by_error.size(), a_tenth(nodes.size())));
  std::vector<std::int32_t> worst;
  for (const auto& [error, node] : by_error) worst.push_back(node);
  std::sort(worst.begin(), worst.end());
  return worst;
}

/// Unflagged share over the probes of the tenth of the nodes where it is smallest.
double least_unflagged(const std::vector<ErrorsOfNode>& nodes) {
  std::vector<const ErrorsOfNode*> order;
  for (const auto& node : nodes) order.push_back(&node);
  const auto share = [](const ErrorsOfNode& node) {
    return 1 - static_cast<double>(node.flagged) / static_cast<double>(node.probes);
  };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return share(*a) < share(*b); });
  double flagged = 0, probes = 0;
  for (std::size_t i = 0; i < a_tenth(order.size()); ++i) {
    flagged += static_cast<double>(order[i]->flagged);
    probes += static_cast<double>(order[i]->probes);
  }
  return probes > 0 ? 1 - flagged / probes : 0;
}

std::optional<WorstNode> worst_node(const std::vector<JudgedProbe>& probes, bool flagged) {
  const JudgedProbe* worst = nullptr;
  const auto counts = [&](const JudgedProbe& p) { return p.solved() && !p.beyond && p.flagged == flagged; };
  for (const auto& p : probes)
    if (counts(p) && (worst == nullptr || p.error_N > worst->error_N)) worst = &p;
  if (worst == nullptr) return std::nullopt;
  std::vector<double> errors;
  for (const auto& p : probes)
    if (counts(p) && p.node == worst->node) errors.push_back(p.error_N);
  return WorstNode{worst->node, worst->error_N, mean_or_nan(errors), worst->largest_N, flagged};
}

constexpr std::array bound_fractions{0.1, 0.05, 0.02};

ErrorsAndBounds errors_and_bounds(const std::vector<JudgedProbe>& probes, double range_m) {
  ErrorsAndBounds out;
  for (const auto& p : probes)
    if (!p.beyond && p.solved() && p.bound_N < std::numeric_limits<double>::infinity())
      out.samples.push_back({p.node, p.depth_m(), p.error_N, p.bound_N, p.largest_N, p.weight});
  out.coverage = coverage_of(out.samples, range_m);
  // Probes that the finite elements do not reach have no force to compare with.
  std::map<std::int32_t, double> largest;
  for (const auto& p : probes)
    if (!p.beyond) largest[p.node] = std::max(largest[p.node], p.largest_N);
  const auto to_R = [](const JudgedProbe& p) { return !p.beyond; };
  const auto bounded = [&](double fraction, const auto& of) {
    return judged(
        probes, [&](const JudgedProbe& p) { return !p.flagged && p.bound_N <= fraction * of(p); }, to_R);
  };
  const auto of_node = [&](const JudgedProbe& p) { return largest.at(p.node); };
  for (const double fraction : bound_fractions) out.at_most.push_back({fraction, bounded(fraction, of_node)});
  out.right =
      bounded(wrong_fraction, [&](const JudgedProbe& p) { return std::max(p.force_N, force_floor * of_node(p)); });
  return out;
}

}  // namespace

JudgedErrors judged(const std::vector<JudgedProbe>& probes, const Belongs& group, const Belongs& part) {
  JudgedErrors out;
  std::int64_t drawn = 0;
  std::vector<const JudgedProbe*> solved;
  for (const auto& probe : probes) {
    if (!part(probe)) continue;
    ++drawn;
    if (!group(probe)) continue;
    ++out.probes;
    if (probe.solved()) solved.push_back(&probe);
  }
  out.solved = std::ssize(solved);
  out.share = drawn > 0 ? static_cast<double>(out.probes) / static_cast<double>(drawn) : 0;
  out.model = statistics(solved, &JudgedProbe::model);
  out.linear = statistics(solved, &JudgedProbe::linear);
  return out;
}

ErrorsToRange errors_to_range(const std::vector<JudgedProbe>& probes, double range_m, const std::string& counted) {
  ErrorsToRange out;
  out.range_m = range_m;
  out.counted = counted;
  std::map<std::int32_t, std::vector<const JudgedProbe*>> by_node;
  for (const auto& probe : probes) {
    if (!probe.beyond) by_node[probe.node].push_back(&probe);
    if (!probe.solved() && probe.beyond) ++out.unreached_beyond;
    if (!probe.solved() && !probe.beyond) out.unreached.push_back(probe);
  }
  for (const auto& [node, of_node] : by_node) out.nodes.push_back(errors_of_node(node, of_node));
  out.worst_nodes = worst_of(out.nodes);
  out.least_unflagged = least_unflagged(out.nodes);
  out.worst = worst_node(probes, false);
  if (!out.worst) out.worst = worst_node(probes, true);
  const auto any = [](const JudgedProbe&) { return true; };
  const auto fill = [&](JudgedGroup& group, const Belongs& in_group) {
    const auto over = [&](const Belongs& part) {
      return judged(probes, in_group, [&](const JudgedProbe& p) { return !p.beyond && part(p); });
    };
    group.counted = counted;
    group.overall = over(any);
    for (int third = 0; third < 3; ++third)
      group.by_depth[static_cast<std::size_t>(third)] = over([&](const JudgedProbe& p) {
        const double x = 3 * p.depth_m() / range_m;
        return (third == 0 || x > third) && (third == 2 || x <= third + 1);
      });
    group.worst_nodes = over([&](const JudgedProbe& p) {
      return std::binary_search(out.worst_nodes.begin(), out.worst_nodes.end(), p.node);
    });
  };
  fill(out.all, any);
  fill(out.unflagged, [](const JudgedProbe& p) { return !p.flagged; });
  fill(out.flagged, [](const JudgedProbe& p) { return p.flagged; });
  out.beyond = judged(probes, any, [](const JudgedProbe& p) { return p.beyond; });
  if (std::any_of(probes.begin(), probes.end(), [](const auto& p) { return !std::isnan(p.bound_N); }))
    out.bounds = errors_and_bounds(probes, range_m);
  return out;
}

ErrorsByWarning errors_by_warning(const std::vector<JudgedProbe>& probes) {
  const auto any = [](const JudgedProbe&) { return true; };
  ErrorsByWarning out;
  out.all = judged(probes, any, any);
  out.unflagged = judged(
      probes, [](const JudgedProbe& p) { return !p.flagged; }, any);
  out.flagged = judged(
      probes, [](const JudgedProbe& p) { return p.flagged; }, any);
  for (const auto& probe : probes)
    if (!probe.solved()) out.unreached.push_back(probe);
  return out;
}

const char* reason(const JudgedProbe& unreached) { return name(unreached.status); }

}  // namespace phynness
