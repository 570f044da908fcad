#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <phynness/planning/ray_sample.hpp>
#include <random>

namespace phynness {
namespace {

/// Costs vary more between nodes than between directions, so that short runs at many nodes are better.
constexpr std::size_t run_length = 2;

/// An integer below n. The distributions of the standard library differ between platforms; the bias of the remainder is
/// 2^-40 here.
std::size_t draw(std::mt19937_64& random, std::size_t n) { return static_cast<std::size_t>(random() % n); }

/// Inverse distance to the nearest fixed point; equal for all if there is none.
std::vector<double> expected_cost(const Points& points, const Points& fixed) {
  std::vector<double> size(static_cast<std::size_t>(points.rows()), 1.0);
  if (fixed.rows() == 0) return size;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    size[static_cast<std::size_t>(i)] = (fixed.rowwise() - points.row(i)).rowwise().norm().minCoeff();
  // The bound prevents a node very close to a fixed node from dominating the sample.
  const double least = 1e-2 * *std::max_element(size.begin(), size.end());
  for (double& s : size) s = least > 0 ? 1 / std::max(s, least) : 1;
  return size;
}

}  // namespace

std::vector<RayChoice> choose_rays(const Points& active_points, const Points& fixed_points,
                                   const std::vector<char>& requested, std::size_t n_directions, std::size_t wanted,
                                   std::uint64_t seed) {
  assert(requested.size() == static_cast<std::size_t>(active_points.rows()) * n_directions);
  // Nodes without requested rays, whose rays are all mirror images, are not used.
  std::vector<std::size_t> order, n_requested;
  for (std::size_t a = 0; a < static_cast<std::size_t>(active_points.rows()); ++a) {
    const auto first = requested.begin() + static_cast<std::ptrdiff_t>(a * n_directions);
    n_requested.push_back(
        static_cast<std::size_t>(std::count(first, first + static_cast<std::ptrdiff_t>(n_directions), char{1})));
    if (n_requested.back() > 0) order.push_back(a);
  }
  const std::size_t n_nodes = order.size();
  if (n_nodes == 0 || wanted == 0) return {};
  std::mt19937_64 random(seed);
  const std::size_t run = std::min(n_directions, std::max(run_length, (wanted + n_nodes - 1) / n_nodes));
  const std::size_t n_draws = std::min(n_nodes, std::max<std::size_t>(1, wanted / run));
  const auto size = expected_cost(active_points, fixed_points);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  double sum = 0;
  for (const std::size_t a : order) sum += size[a];
  const double step = sum / static_cast<double>(n_draws);
  const double offset = step * std::ldexp(static_cast<double>(random() >> 11), -53);

  std::map<std::pair<std::int32_t, std::int32_t>, double> weights;
  std::size_t next_direction = draw(random, n_directions), place = 0;
  double passed = size[order[0]];
  for (std::size_t k = 0; k < n_draws; ++k) {
    while (passed <= offset + static_cast<double>(k) * step && place + 1 < n_nodes) passed += size[order[++place]];
    const std::size_t active = order[place];
    std::vector<std::int32_t> directions;
    for (std::size_t i = 0; i < n_directions && directions.size() < run; ++i) {
      const std::size_t d = (next_direction + i) % n_directions;
      if (requested[active * n_directions + d]) directions.push_back(static_cast<std::int32_t>(d));
    }
    next_direction = (next_direction + run) % n_directions;
    for (const auto d : directions)
      weights[{static_cast<std::int32_t>(active), d}] +=
          static_cast<double>(n_requested[active]) / size[active] / static_cast<double>(directions.size());
  }
  std::vector<RayChoice> chosen;
  for (const auto& [ray, weight] : weights) chosen.push_back({ray.first, ray.second, weight});
  return chosen;
}

namespace {

/// Weight and weighted cost of the rays of each node in the sample.
std::vector<std::pair<double, double>> nodes_of(const RaySample& sample) {
  std::vector<std::pair<double, double>> nodes;
  for (std::size_t i = 0; i < sample.rays.size(); ++i) {
    if (i == 0 || sample.rays[i].active != sample.rays[i - 1].active) nodes.emplace_back(0.0, 0.0);
    nodes.back().first += sample.rays[i].weight;
    nodes.back().second += sample.rays[i].weight * sample.seconds[i];
  }
  return nodes;
}

}  // namespace

double RaySample::mean_ray_seconds() const {
  double weight = 0, cost = 0;
  for (const auto& [w, c] : nodes_of(*this)) weight += w, cost += c;
  return weight > 0 ? cost / weight : 0;
}

std::optional<double> RaySample::relative_error() const {
  const auto nodes = nodes_of(*this);
  const auto n = static_cast<double>(nodes.size());
  const double mean = mean_ray_seconds();
  if (nodes.size() < fewest_nodes || !(mean > 0)) return {};
  double weight = 0, squares = 0;
  for (const auto& [w, c] : nodes) {
    weight += w;
    squares += (c - w * mean) * (c - w * mean);  // residual of the ratio estimate sum c / sum w
  }
  return std::sqrt(squares * n / (n - 1)) / weight / mean;
}

}  // namespace phynness
