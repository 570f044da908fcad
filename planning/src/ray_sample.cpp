#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <phynness/planning/ray_sample.hpp>
#include <random>

namespace phynness {
namespace {

constexpr std::size_t run_length = 4;

/// A whole number below n. The standard's distributions differ between libraries; the remainder's bias is
/// 2^-40 here.
std::size_t draw(std::mt19937_64& random, std::size_t n) { return static_cast<std::size_t>(random() % n); }

/// Place on a Morton curve through the bounding box, 20 bits a coordinate.
std::uint64_t morton(const Eigen::RowVector3d& x, const Eigen::RowVector3d& low, double extent) {
  std::uint64_t code = 0;
  for (int k = 0; k < 3; ++k) {
    const double t = extent > 0 ? (x[k] - low[k]) / extent : 0;
    const auto cell = static_cast<std::uint64_t>(std::clamp(t, 0.0, 1.0) * ((1 << 20) - 1));
    for (int bit = 0; bit < 20; ++bit) code |= (cell >> bit & 1) << (3 * bit + k);
  }
  return code;
}

std::vector<std::int32_t> along_the_curve(const Points& points) {
  const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  const double extent = (high - low).maxCoeff();
  std::vector<std::uint64_t> code(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    code[static_cast<std::size_t>(i)] = morton(points.row(i), low, extent);
  std::vector<std::int32_t> order(code.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return code[static_cast<std::size_t>(a)] < code[static_cast<std::size_t>(b)];
  });
  return order;
}

}  // namespace

std::vector<RayChoice> choose_rays(const Points& active_points, const std::vector<char>& requested,
                                   std::size_t n_directions, std::size_t wanted, std::uint64_t seed) {
  const auto n_active = static_cast<std::size_t>(active_points.rows());
  assert(requested.size() == n_active * n_directions);
  if (n_active == 0 || wanted == 0) return {};
  std::mt19937_64 random(seed);
  const std::size_t run = std::min(n_directions, std::max(run_length, (wanted + n_active - 1) / n_active));
  const std::size_t n_nodes = std::min(n_active, std::max<std::size_t>(1, wanted / run));
  const auto order = along_the_curve(active_points);
  std::vector<RayChoice> chosen;
  std::size_t next_direction = draw(random, n_directions);
  for (std::size_t k = 0; k < n_nodes; ++k) {
    const std::size_t first = k * n_active / n_nodes, last = (k + 1) * n_active / n_nodes;
    const auto active = order[first + draw(random, last - first)];
    std::size_t taken = 0;
    for (std::size_t step = 0; step < n_directions && taken < run; ++step) {
      const std::size_t d = (next_direction + step) % n_directions;
      if (!requested[static_cast<std::size_t>(active) * n_directions + d]) continue;
      chosen.push_back({active, static_cast<std::int32_t>(d)});
      ++taken;
    }
    next_direction = (next_direction + run) % n_directions;
  }
  std::stable_sort(chosen.begin(), chosen.end(), [](const RayChoice& a, const RayChoice& b) {
    return a.active != b.active ? a.active < b.active : a.direction < b.direction;
  });
  return chosen;
}

double RaySample::mean_ray_seconds() const {
  if (rays.empty()) return 0;
  return std::accumulate(seconds.begin(), seconds.end(), 0.0) / static_cast<double>(rays.size());
}

double RaySample::relative_error() const {
  std::vector<double> node_mean;
  const auto n_increments = static_cast<std::size_t>(increments);
  for (std::size_t first = 0; first < rays.size();) {
    std::size_t last = first;
    while (last < rays.size() && rays[last].active == rays[first].active) ++last;
    const auto from = seconds.begin() + static_cast<std::ptrdiff_t>(first * n_increments);
    const auto to = seconds.begin() + static_cast<std::ptrdiff_t>(last * n_increments);
    node_mean.push_back(std::accumulate(from, to, 0.0) / static_cast<double>(last - first));
    first = last;
  }
  const auto n = static_cast<double>(node_mean.size());
  if (n < 2) return 0;
  const double mean = std::accumulate(node_mean.begin(), node_mean.end(), 0.0) / n;
  double squares = 0;
  for (const double x : node_mean) squares += (x - mean) * (x - mean);
  return mean > 0 ? std::sqrt(squares / (n - 1) / n) / mean : 0;
}

RayWork work_like(const RaySample& sample, const std::vector<char>& requested, std::size_t n_directions,
                  std::uint64_t seed) {
  RayWork work;
  work.increments = sample.increments;
  const auto n_increments = static_cast<std::size_t>(sample.increments);
  work.seconds.assign(requested.size() * n_increments, 0.0);
  work.node.resize(requested.size());
  for (std::size_t ray = 0; ray < requested.size(); ++ray)
    work.node[ray] = static_cast<std::int32_t>(ray / n_directions);
  if (sample.rays.empty()) return work;

  std::vector<std::size_t> rays;
  for (std::size_t ray = 0; ray < requested.size(); ++ray)
    if (requested[ray]) rays.push_back(ray);
  std::mt19937_64 random(seed);
  for (std::size_t i = rays.size(); i > 1; --i) std::swap(rays[i - 1], rays[draw(random, i)]);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::size_t from = i % sample.rays.size();
    std::copy_n(sample.seconds.begin() + static_cast<std::ptrdiff_t>(from * n_increments), n_increments,
                work.seconds.begin() + static_cast<std::ptrdiff_t>(rays[i] * n_increments));
  }
  return work;
}

}  // namespace phynness
