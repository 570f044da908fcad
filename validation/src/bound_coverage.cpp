#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <phynness/validation/bound_coverage.hpp>

namespace phynness {
namespace {

/// Shares in groups of displacements.
template <std::size_t n>
struct Shares {
  std::array<double, n> held{}, drawn{};

  void add(std::size_t group, bool holds) {
    held[group] += holds ? 1 : 0;
    drawn[group] += 1;
  }
  std::array<double, n> values() const {
    std::array<double, n> out{};
    for (std::size_t i = 0; i < n; ++i)
      out[i] = drawn[i] > 0 ? held[i] / drawn[i] : std::numeric_limits<double>::quiet_NaN();
    return out;
  }
};

/// Quarter of each node in the order of the mean of bound over largest force, which is known without the errors.
std::map<std::int32_t, std::size_t> quarters_of(const std::vector<BoundedError>& errors) {
  std::map<std::int32_t, std::pair<double, double>> of_node;  // sum of the ratios, and their number
  for (const auto& e : errors) {
    of_node[e.node].first += e.largest_N > 0 ? e.bound_N / e.largest_N : 0;
    of_node[e.node].second += 1;
  }
  std::vector<std::pair<double, std::int32_t>> order;
  for (const auto& [node, sum] : of_node) order.emplace_back(sum.first / sum.second, node);
  std::sort(order.begin(), order.end());
  std::map<std::int32_t, std::size_t> quarter;
  for (std::size_t i = 0; i < order.size(); ++i) quarter[order[i].second] = 4 * i / order.size();
  return quarter;
}

/// The smallest number that is at least the share `coverage` of the errors.
double constant_bound(const std::vector<BoundedError>& errors, std::int64_t held) {
  std::vector<double> sizes;
  for (const auto& e : errors) sizes.push_back(e.error_N);
  std::sort(sizes.begin(), sizes.end());
  return sizes[static_cast<std::size_t>(std::max<std::int64_t>(held, 1) - 1)];
}

}  // namespace

BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m) {
  BoundCoverage out;
  out.states = std::ssize(errors);
  const auto quarter = quarters_of(errors);
  Shares<3> thirds;
  Shares<4> quarters;
  std::int64_t held = 0;
  double sum = 0;
  for (const auto& e : errors) {
    const bool holds = e.error_N <= e.bound_N;
    held += holds ? 1 : 0;
    sum += e.bound_N;
    thirds.add(std::min<std::size_t>(2, static_cast<std::size_t>(3 * e.depth_m / range_m)), holds);
    quarters.add(quarter.at(e.node), holds);
  }
  out.thirds = thirds.values();
  out.quarters = quarters.values();
  if (errors.empty()) return out;
  const auto n = static_cast<double>(errors.size());
  out.all = static_cast<double>(held) / n;
  const double constant = constant_bound(errors, held);
  out.width = constant > 0 ? sum / n / constant : std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace phynness
