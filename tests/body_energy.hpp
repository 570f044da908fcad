// The energy of a reduced body without tools.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <phynness/formats/body.hpp>

namespace phynness::test {

/// The energy of a neo-Hookean body (formats/body.md).
inline double energy(const ReducedBody& body, const Eigen::VectorXd& q) {
  const auto mu = [&](std::size_t c) {
    const auto region = body.region_of_cell.empty() ? 0 : body.region_of_cell[c];
    return region > 0 ? body.regions(region - 1, 0) : body.parameters.at(0);
  };
  const Eigen::VectorXd F = body.gradients.values() * q;
  const Eigen::MatrixXd pressures = body.pressures.values();
  Eigen::VectorXd b = Eigen::VectorXd::Zero(pressures.cols());
  double sum = 0;
  for (Eigen::Index c = 0; c < pressures.rows(); ++c) {
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + Eigen::Map<const Eigen::Matrix3d>(F.data() + 9 * c);
    const double J = f.determinant();
    sum += body.shear_m3[static_cast<std::size_t>(c)] * mu(static_cast<std::size_t>(c)) *
           ((f.squaredNorm() - 3) / 2 - std::log(J));
    b += body.bulk_rJ[static_cast<std::size_t>(c)] * (J - 1) * pressures.row(c).transpose();
  }
  return sum + b.squaredNorm() / 2;
}

}  // namespace phynness::test
