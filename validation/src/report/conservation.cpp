#include "blocks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <phynness/validation/probe_plan.hpp>

#include "closed_paths.hpp"

namespace phynness::report {

Conservation closed_paths(const LoadedModel& model, int n_paths, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Conservation found;
  found.has_energy = schema::traits(model.model().family).has_energy;
  std::vector<double> ratios;
  const auto& nodes = model.model().nodes;
  for (int path = 0; path < n_paths && !nodes.empty(); ++path) {
    const auto& node = nodes[static_cast<std::size_t>(uniform(random) * static_cast<double>(nodes.size()))];
    std::array<Eigen::Vector3d, 4> corners;
    for (auto& corner : corners) {
      const Vec3 direction = on_sphere(random);
      const double depth = model.trained_depth(node.node, direction) * std::cbrt(uniform(random));
      corner = depth * Eigen::Vector3d(direction[0], direction[1], direction[2]);
    }
    const Loop loop = around_quadrilateral(corners, [&](const Eigen::Vector3d& d, Eigen::Vector3d& force) {
      return force_and_energy(model, node.node, d, force);
    });
    if (loop.energy > 0) ratios.push_back(std::abs(loop.work) / loop.energy);
  }
  std::sort(ratios.begin(), ratios.end());
  found.paths = static_cast<int>(ratios.size());
  if (!ratios.empty()) {
    found.median = ratios[ratios.size() / 2];
    found.largest = ratios.back();
  }
  return found;
}

}  // namespace phynness::report
