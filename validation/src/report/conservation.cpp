#include "blocks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <phynness/validation/probe_plan.hpp>

namespace phynness::report {
namespace {

struct Loop {
  double work = 0, energy = 0;  ///< [J]: along the path; largest value on the path
};

/// Force of a node, and its energy [J]; in families without an energy the work |f . d| / 2.
double force_and_energy(const LoadedModel& model, std::int32_t node, const Eigen::Vector3d& d, Eigen::Vector3d& force) {
  double energy = 0;
  if (model.runtime().info().has_energy) return model.data().force(node, d, force, energy).ok() ? energy : 0;
  return model.data().force(node, d, force).ok() ? force.dot(d) / 2 : 0;
}

/// Integral along a quadrilateral of displacements [m] with eight Gauss-Legendre points on each of 100 pieces of each
/// side. Half as many pieces do not change the first two digits of any figure.
Loop around_quadrilateral(const LoadedModel& model, std::int32_t node, const std::array<Eigen::Vector3d, 4>& corners) {
  static constexpr std::array<double, 4> x{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                           0.9602898564975363},
      w{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  constexpr int pieces = 100;
  Loop loop;
  for (std::size_t side = 0; side < 4; ++side) {
    const Eigen::Vector3d along = corners[(side + 1) % 4] - corners[side];
    for (int i = 0; i < pieces; ++i)
      for (std::size_t j = 0; j < 8; ++j) {
        const double z = j % 2 ? x[j / 2] : -x[j / 2];
        Eigen::Vector3d force;
        const double energy = force_and_energy(model, node, corners[side] + (i + (1 + z) / 2) / pieces * along, force);
        loop.work += w[j / 2] / (2 * pieces) * force.dot(along);
        loop.energy = std::max(loop.energy, std::abs(energy));
      }
  }
  return loop;
}

}  // namespace

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
    const Loop loop = around_quadrilateral(model, node.node, corners);
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
