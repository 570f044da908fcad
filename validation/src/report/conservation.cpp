#include "conservation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <phynness/validation/probe_plan.hpp>

namespace phynness::report {

Conservation closed_paths(const LoadedModel& model, int n_paths, std::uint64_t seed) {
  // Four points, exact for the seventh power, on 100 pieces of a side: a kernel's shape is some hundredths of
  // the range.
  constexpr std::array<double, 4> x{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                    0.8611363115940526},
      w{0.3478548451374539, 0.6521451548625461, 0.6521451548625461, 0.3478548451374539};
  constexpr int pieces = 100;
  std::mt19937_64 random(seed);
  Conservation found;
  std::vector<double> ratios;
  const auto& nodes = model.model().nodes;
  for (int path = 0; path < n_paths && !nodes.empty(); ++path) {
    const auto& node = nodes[static_cast<std::size_t>(uniform(random) * static_cast<double>(nodes.size()))];
    std::array<Eigen::Vector3d, 4> corner;
    for (auto& c : corner) {
      const Vec3 direction = on_sphere(random);
      const double depth = model.trained_depth(node.node, direction) * std::cbrt(uniform(random));
      c = depth * Eigen::Vector3d(direction[0], direction[1], direction[2]);
    }
    double work = 0, energy = 0;
    for (std::size_t side = 0; side < 4; ++side) {
      const Eigen::Vector3d along = corner[(side + 1) % 4] - corner[side];
      for (int i = 0; i < pieces; ++i) {
        for (std::size_t g = 0; g < x.size(); ++g) {
          const Eigen::Vector3d d = corner[side] + (i + (1 + x[g]) / 2) / pieces * along;
          const Vec3 force = model.force(node.node, {d[0], d[1], d[2]});
          const Eigen::Vector3d f(force[0], force[1], force[2]);
          work += w[g] / (2 * pieces) * f.dot(along);
          double stored = 0;
          found.has_energy = phn_energy(model.handle(), model.data(), node.node, d.data(), &stored) >= 0;
          energy = std::max(energy, found.has_energy ? std::abs(stored) : std::abs(f.dot(d)) / 2);
        }
      }
    }
    if (energy > 0) ratios.push_back(std::abs(work) / energy);
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
