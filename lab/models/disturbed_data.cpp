#include "disturbed_data.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace phynness::study {
namespace {

/// The same numbers on every platform, which the distributions of the standard library do not guarantee.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

double normal(std::mt19937_64& random) {
  const double r = std::sqrt(-2 * std::log(1 - uniform(random)));
  return r * std::cos(2 * std::numbers::pi * uniform(random));
}

template <class Change>
StudyData changed(StudyData data, Change change) {
  for (auto* list : {&data.probed, &data.others})
    for (auto& node : *list) change(node);
  return data;
}

double length(const double* v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

void fail(Ray& ray, std::size_t from) {
  const std::size_t n = ray.status.size(), per_increment = ray.displacement.size() / n;
  bool first = true;
  for (std::size_t i = from; i < n; ++i) {
    if (ray.status[i] == Status::not_requested) continue;
    ray.status[i] = first ? Status::diverged : Status::after_failure;
    first = false;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::fill_n(ray.force.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, nan);
    std::fill_n(ray.displacement.begin() + static_cast<std::ptrdiff_t>(per_increment * i), per_increment, nan);
  }
}

double largest_displacement_m(const DatabaseHeader& header, const StudyNode& node) {
  double largest = 0;
  const std::size_t n_output = header.sets.output.size();
  for (const Ray& ray : node.rays)
    for (std::size_t i = 0; i < ray.status.size(); ++i) {
      if (ray.status[i] != Status::converged) continue;
      for (std::size_t o = 0; o < n_output; ++o)
        if (!node.tool.holds(header.sets.output[o]))
          largest = std::max(largest, length(&ray.displacement[3 * (i * n_output + o)]));
    }
  return largest;
}

void add_noise(const DatabaseHeader& header, StudyNode& node, std::vector<Ray>& rays, double level,
               std::uint64_t seed) {
  std::mt19937_64 random(seed + static_cast<std::uint64_t>(node.node));
  const double force = level * largest_force_N(node.rays), displacement = level * largest_displacement_m(header, node);
  for (Ray& ray : rays) {
    for (double& f : ray.force) f += force * normal(random);
    for (double& u : ray.displacement) u += displacement * normal(random);
  }
}

}  // namespace

double largest_force_N(const std::vector<Ray>& rays) {
  double largest = 0;
  for (const Ray& ray : rays)
    for (std::size_t i = 0; i < ray.status.size(); ++i)
      if (ray.status[i] == Status::converged) largest = std::max(largest, length(&ray.force[3 * i]));
  return largest;
}

StudyData read_data(const Database& database, std::vector<std::int32_t> probed, int n_others, double tool_radius_m) {
  std::sort(probed.begin(), probed.end());
  StudyData data;
  data.header = database.header();
  const auto& header = data.header;
  const auto& active = header.sets.active;
  const auto read = [&](std::int32_t index) {
    const std::int32_t node = active[static_cast<std::size_t>(index)];
    const auto x = header.mesh.nodes.row(node);
    StudyNode read{
        node,
        {x[0], x[1], x[2]},
        touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, at_node(node), tool_radius_m),
        database.rays(index)};
    for (Ray& ray : read.rays) {
      ray.energy.clear();
      ray.tangent.clear();
    }
    return read;
  };
  for (const auto node : probed)
    data.probed.push_back(
        read(static_cast<std::int32_t>(std::lower_bound(active.begin(), active.end(), node) - active.begin())));
  const auto n_active = static_cast<std::int64_t>(active.size());
  const auto n = std::min<std::int64_t>(n_others, n_active);
  for (std::int64_t i = 0; i < n; ++i) {
    const auto index = static_cast<std::int32_t>((2 * i + 1) * n_active / (2 * n));
    if (std::find(probed.begin(), probed.end(), active[static_cast<std::size_t>(index)]) == probed.end())
      data.others.push_back(read(index));
  }
  return data;
}

StudyData with_increments(StudyData data, const std::vector<std::size_t>& kept) {
  const std::size_t n = data.header.magnitudes_m.size(), per_increment = 3 * data.header.sets.output.size();
  std::vector<double> magnitudes_m;
  for (const auto i : kept) magnitudes_m.push_back(data.header.magnitudes_m[i]);
  data.header.magnitudes_m = magnitudes_m;
  return changed(std::move(data), [&](StudyNode& node) {
    for (Ray& ray : node.rays) {
      Ray some = ray;
      some.status.clear();
      some.force.clear();
      some.displacement.clear();
      for (const auto i : kept) {
        const auto copy = [i, n](const std::vector<double>& from, std::vector<double>& to, std::size_t size) {
          if (from.size() != n * size) return;
          const auto begin = from.begin() + static_cast<std::ptrdiff_t>(i * size);
          to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(size));
        };
        some.status.push_back(ray.status[i]);
        copy(ray.force, some.force, 3);
        copy(ray.displacement, some.displacement, per_increment);
      }
      ray = std::move(some);
    }
  });
}

StudyData with_failed_rays(StudyData data, double share, std::uint64_t seed) {
  return changed(std::move(data), [&](StudyNode& node) {
    std::mt19937_64 random(seed + static_cast<std::uint64_t>(node.node));
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < node.rays.size(); ++i) order.emplace_back(uniform(random), i);
    std::sort(order.begin(), order.end());
    const auto n = static_cast<std::size_t>(std::lround(share * static_cast<double>(order.size())));
    for (std::size_t i = 0; i < n; ++i) fail(node.rays[order[i].second], 0);
  });
}

StudyData with_rays(StudyData data, const std::vector<std::size_t>& kept) {
  return changed(std::move(data), [&](StudyNode& node) {
    for (std::size_t i = 0; i < node.rays.size(); ++i)
      if (std::find(kept.begin(), kept.end(), i) == kept.end()) fail(node.rays[i], 0);
  });
}

StudyData failing_from(StudyData data, std::size_t increment) {
  return changed(std::move(data), [&](StudyNode& node) {
    for (Ray& ray : node.rays)
      if (increment == 0 || ray.status[increment - 1] == Status::converged) fail(ray, increment);
  });
}

StudyData duplicated(StudyData data, double level, std::uint64_t seed) {
  const auto once = data.header.directions;
  data.header.directions.insert(data.header.directions.end(), once.begin(), once.end());
  const DatabaseHeader header = data.header;
  return changed(std::move(data), [&](StudyNode& node) {
    auto copies = node.rays;
    if (level > 0) add_noise(header, node, copies, level, seed);
    for (Ray& ray : copies) ray.direction += static_cast<std::int32_t>(once.size());
    node.rays.insert(node.rays.end(), copies.begin(), copies.end());
  });
}

StudyData with_noise(StudyData data, double level, std::uint64_t seed) {
  const DatabaseHeader header = data.header;
  return changed(std::move(data), [&](StudyNode& node) { add_noise(header, node, node.rays, level, seed); });
}

}  // namespace phynness::study
