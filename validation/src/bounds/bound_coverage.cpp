#include <algorithm>
#include <limits>
#include <map>
#include <phynness/validation/bound_coverage.hpp>

namespace phynness {
namespace {

/// Shares in groups of displacements.
template <std::size_t n>
struct Shares {
  std::array<double, n> held{}, drawn{};

  void add(std::size_t group, double weight, bool holds) {
    held[group] += holds ? weight : 0;
    drawn[group] += weight;
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

/// The smallest number that is at least errors of the weight `held`.
double constant_bound(const std::vector<BoundedError>& errors, double held) {
  std::vector<std::pair<double, double>> order;  // error, weight
  for (const auto& e : errors) order.emplace_back(e.error_N, e.weight);
  std::sort(order.begin(), order.end());
  double below = 0;
  for (const auto& [error, weight] : order) {
    below += weight;
    if (below >= held * (1 - 1e-12)) return error;  // sums in another order differ by rounding
  }
  return order.back().first;
}

}  // namespace

BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m) {
  BoundCoverage out;
  out.states = std::ssize(errors);
  const auto quarter = quarters_of(errors);
  Shares<3> thirds;
  Shares<4> quarters;
  double all = 0, held = 0, sum = 0;
  for (const auto& e : errors) {
    const bool holds = e.error_N <= e.bound_N;
    all += e.weight;
    held += holds ? e.weight : 0;
    sum += e.weight * e.bound_N;
    thirds.add(std::min<std::size_t>(2, static_cast<std::size_t>(3 * e.depth_m / range_m)), e.weight, holds);
    quarters.add(quarter.at(e.node), e.weight, holds);
  }
  out.thirds = thirds.values();
  out.quarters = quarters.values();
  if (errors.empty()) return out;
  out.all = held / all;
  const double constant = constant_bound(errors, held);
  out.width = constant > 0 ? sum / all / constant : std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace phynness
