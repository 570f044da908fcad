// Two layers of different materials that meet at a plane: the strain on one side from that on the other.
#pragma once

#include <Eigen/LU>

#include "closed_forms.hpp"

namespace phynness::test {

/// The vector a with which the other material has the displacement gradient H + a e_z^T: displacements and tractions
/// P e_z are then continuous at a plane z = const. Newton's method to rounding.
inline Eigen::Vector3d jump_of_strain(const Material& of_H, const Material& other, const Eigen::Matrix3d& H) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + H;
  const Eigen::Vector3d traction = first_piola(of_H, F) * z;
  const auto excess = [&](const Eigen::Vector3d& a) -> Eigen::Vector3d {
    return first_piola(other, F + a * z.transpose()) * z - traction;
  };
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  for (int i = 0; i < 50; ++i) {
    Eigen::Matrix3d slope;
    for (int k = 0; k < 3; ++k)
      slope.col(k) = (excess(a + 1e-6 * Eigen::Vector3d::Unit(k)) - excess(a - 1e-6 * Eigen::Vector3d::Unit(k))) / 2e-6;
    a -= slope.lu().solve(excess(a));
  }
  return a;
}

}  // namespace phynness::test
