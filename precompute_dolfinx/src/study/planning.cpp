#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numeric>
#include <phynness/precompute/planning.hpp>
#include <random>

namespace phynness {
namespace {

/// Number of rays of a sampled node, if there are enough nodes. It is small, because costs vary more between nodes than
/// between directions.
constexpr std::size_t run_length = 2;

/// The inverse distances to the nearest fixed point; they are equal if there is none.
std::vector<double> expected_cost(const Points& points, const Points& fixed) {
  std::vector<double> cost(static_cast<std::size_t>(points.rows()), 1.0);
  if (fixed.rows() == 0) return cost;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    cost[static_cast<std::size_t>(i)] = (fixed.rowwise() - points.row(i)).rowwise().norm().minCoeff();
  // The bound prevents a node very close to a fixed node from dominating the sample.
  const double smallest = 1e-2 * *std::max_element(cost.begin(), cost.end());
  for (double& s : cost) s = smallest > 0 ? 1 / std::max(s, smallest) : 1;
  return cost;
}

}  // namespace

std::vector<RayChoice> choose_rays(const Points& active_points, const Points& fixed_points,
                                   const std::vector<char>& requested, std::size_t n_directions, std::size_t wanted,
                                   std::uint64_t seed) {
  assert(requested.size() == static_cast<std::size_t>(active_points.rows()) * n_directions);
  // Nodes without requested rays are not used.
  std::vector<std::size_t> order, n_requested;
  for (std::size_t a = 0; a < static_cast<std::size_t>(active_points.rows()); ++a) {
    const auto first = requested.begin() + static_cast<std::ptrdiff_t>(a * n_directions);
    n_requested.push_back(
        static_cast<std::size_t>(std::count(first, first + static_cast<std::ptrdiff_t>(n_directions), char{1})));
    if (n_requested.back() > 0) order.push_back(a);
  }
  const std::size_t n_nodes = order.size();
  if (n_nodes == 0 || wanted == 0) return {};
  // The distributions of the standard library differ between platforms; the bias of a remainder is 2^-40 here.
  std::mt19937_64 random(seed);
  const std::size_t run = std::min(n_directions, std::max(run_length, (wanted + n_nodes - 1) / n_nodes));
  const std::size_t n_draws = std::min(n_nodes, std::max<std::size_t>(1, wanted / run));
  const auto cost = expected_cost(active_points, fixed_points);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cost[a] > cost[b]; });
  const double sum = std::accumulate(order.begin(), order.end(), 0.0, [&](double s, auto a) { return s + cost[a]; });
  const double step = sum / static_cast<double>(n_draws);
  const double offset = step * std::ldexp(static_cast<double>(random() >> 11), -53);

  std::map<std::pair<std::int32_t, std::int32_t>, double> weights;
  std::size_t next_direction = random() % n_directions, position = 0;
  double cumulative_cost = cost[order[0]];
  for (std::size_t k = 0; k < n_draws; ++k) {
    while (cumulative_cost <= offset + static_cast<double>(k) * step && position + 1 < n_nodes)
      cumulative_cost += cost[order[++position]];
    const std::size_t active = order[position];
    std::vector<std::int32_t> directions;
    for (std::size_t i = 0; i < n_directions && directions.size() < run; ++i) {
      const std::size_t d = (next_direction + i) % n_directions;
      if (requested[active * n_directions + d]) directions.push_back(static_cast<std::int32_t>(d));
    }
    next_direction = (next_direction + run) % n_directions;
    for (const auto d : directions)
      weights[{static_cast<std::int32_t>(active), d}] +=
          static_cast<double>(n_requested[active]) / cost[active] / static_cast<double>(directions.size());
  }
  std::vector<RayChoice> chosen;
  for (const auto& [ray, weight] : weights) chosen.push_back({ray.first, ray.second, weight});
  return chosen;
}

RayCosts costs_of(const std::vector<RayChoice>& rays, const std::vector<double>& seconds) {
  RayCosts costs;
  costs.longest_s = *std::max_element(seconds.begin(), seconds.end());
  std::vector<std::pair<double, double>> nodes;  // weight and weighted cost of all rays of a node
  double weight = 0, cost = 0, squares = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (i == 0 || rays[i].active != rays[i - 1].active) nodes.emplace_back(0.0, 0.0);
    weight += rays[i].weight;
    cost += rays[i].weight * seconds[i];
    nodes.back().first += rays[i].weight;
    nodes.back().second += rays[i].weight * seconds[i];
  }
  const double mean = costs.mean_s = cost / weight, n = static_cast<double>(nodes.size());
  for (const auto& [w, c] : nodes) squares += (c - w * mean) * (c - w * mean);  // residuals of the ratio sum c / sum w
  if (nodes.size() >= RayCosts::fewest_nodes && mean > 0)
    costs.relative_error = std::sqrt(squares * n / (n - 1)) / weight / mean;
  return costs;
}

double wall_seconds(const RunCosts& costs, int ranks) {
  const double solving =
      static_cast<double>(costs.rays) * costs.ray_s + static_cast<double>(costs.nodes + ranks - 1) * costs.setup_s;
  return costs.start_s + std::max(solving / ranks, costs.longest_s + costs.setup_s) +
         costs.packing_s / static_cast<double>(std::clamp<std::int64_t>(costs.nodes, 1, ranks));
}

int max_useful_ranks(const RunCosts& costs) {
  int ranks = 1;
  while (ranks < costs.rays && (ranks + 1) * wall_seconds(costs, ranks + 1) <= 2 * wall_seconds(costs, 1)) ++ranks;
  return ranks;
}

}  // namespace phynness
