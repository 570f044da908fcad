// Effect of the runtime's precision on the forces of a trained model of family modal.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <phynness/formats/model.hpp>
#include <phynness/phynness.hpp>
#include <phynness/training/conservative_fit.hpp>

#include "liver_sized_model.hpp"
#include "median_time.hpp"

namespace phynness::bench {

struct MedianAndWorst {
  double median = 0, worst = 0;
};
inline MedianAndWorst median_and_worst(const std::vector<double>& values) {
  return {median(values), *std::max_element(values.begin(), values.end())};
}

/// A displacement relative to the trained depth, uniform in the unit ball.
inline Eigen::Vector3d within_depth(Arbitrary& arbitrary) {
  Eigen::Vector3d x;
  for (double& component : x) component = arbitrary.number() / std::sqrt(3.0);
  return x;
}

inline void check_force(Organ::Status status) {
  if (!status.ok()) throw std::runtime_error(status.message());
}

/// For each node: the largest difference from sums in double over the largest force of the node, for 400 displacements.
inline MedianAndWorst rounding_of_forces(const Model& model, Organ& organ) {
  Arbitrary arbitrary;
  std::vector<double> errors;
  for (const auto& node : model.nodes) {
    double largest = 0, error = 0;
    for (int trial = 0; trial < 400; ++trial) {
      const Eigen::Vector3d x = within_depth(arbitrary), d = model.max_displacement_m * x;
      Eigen::Vector3d force;
      check_force(organ.hold(phn_tool_at(node.node, d.data()), force));
      const Eigen::Vector3d in_double =
          evaluate_force(node.conservative, model.displacements, model.max_displacement_m, x);
      largest = std::max(largest, in_double.norm());
      error = std::max(error, (force - in_double).norm());
    }
    errors.push_back(error / largest);
  }
  return median_and_worst(errors);
}

/// Work along a quadrilateral of displacements over the largest energy on the path, with three Gauss-Legendre points on
/// each of `pieces` parts of each side.
inline double work_of_loop(Organ& organ, std::int32_t node, const std::array<Eigen::Vector3d, 4>& corners) {
  constexpr int pieces = 300;
  const double off = std::sqrt(0.15);
  constexpr std::array<double, 3> weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
  double work = 0, most_energy = 0;
  for (std::size_t side = 0; side < 4; ++side) {
    const Eigen::Vector3d step = (corners[(side + 1) % 4] - corners[side]) / pieces;
    for (int i = 0; i < pieces; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const Eigen::Vector3d d = corners[side] + (i + 0.5 + off * (static_cast<double>(j) - 1)) * step;
        Eigen::Vector3d force;
        double energy = 0;
        check_force(organ.hold(phn_tool_at(node, d.data()), force, energy));
        work += weight[j] * force.dot(step);
        most_energy = std::max(most_energy, std::abs(energy));
      }
  }
  return std::abs(work) / most_energy;
}

/// 100 quadrilaterals at each node, with corners uniform in a ball around rest.
/// @param share  radius of the ball over the trained depth. An error of the force has more influence in small loops,
///               whose energy is proportional to the square of their size
inline MedianAndWorst work_of_loops(const Model& model, Organ& organ, double share) {
  Arbitrary arbitrary;
  std::vector<double> work;
  for (const auto& node : model.nodes)
    for (int loop = 0; loop < 100; ++loop) {
      std::array<Eigen::Vector3d, 4> corners;
      for (auto& corner : corners) {
        do {
          corner = std::sqrt(3.0) * within_depth(arbitrary);
        } while (corner.norm() > 1);
        corner *= share * model.max_displacement_m;
      }
      work.push_back(work_of_loop(organ, node.node, corners));
    }
  return median_and_worst(work);
}

}  // namespace phynness::bench
