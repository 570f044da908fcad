// The four laws a second time, written out by hand: energy density, first Piola-Kirchhoff stress, mean
// pressure. The solver's own stress is UFL's derivative of its energy, so these are independent of it.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <phynness/formats/scene.hpp>

namespace phynness::test {

/// The pressure unknown of mixed elements in a homogeneous state: kappa g(F) of forms/mechanics.py.
inline double pressure(const Material& m, const Eigen::Matrix3d& F) {
  switch (m.law) {
    case Law::linear:
      return m.lame_lambda_Pa * (F.trace() - 3);
    case Law::st_venant_kirchhoff:
      return m.lame_lambda_Pa * (F.squaredNorm() - 3) / 2;
    case Law::neo_hookean:
      return m.lame_lambda_Pa * std::log(F.determinant());
    case Law::mooney_rivlin:
      break;
  }
  return m.bulk_modulus_Pa * (F.determinant() - 1);
}

/// W(F), energy per reference volume.
inline double energy_density(const Material& m, const Eigen::Matrix3d& F) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), C = F.transpose() * F;
  const double mu = m.shear_modulus_Pa, lambda = m.lame_lambda_Pa, J = F.determinant();
  switch (m.law) {
    case Law::linear: {
      const Eigen::Matrix3d e = (F + F.transpose()) / 2 - I;
      return lambda / 2 * e.trace() * e.trace() + mu * e.squaredNorm();
    }
    case Law::st_venant_kirchhoff: {
      const Eigen::Matrix3d E = (C - I) / 2;
      return lambda / 2 * E.trace() * E.trace() + mu * E.squaredNorm();
    }
    case Law::neo_hookean:
      return mu / 2 * (C.trace() - 3) - mu * std::log(J) + lambda / 2 * std::log(J) * std::log(J);
    case Law::mooney_rivlin:
      break;
  }
  const double first = C.trace(), second = (first * first - C.squaredNorm()) / 2;
  return m.c10_Pa * (std::pow(J, -2.0 / 3) * first - 3) + m.c01_Pa * (std::pow(J, -4.0 / 3) * second - 3) +
         m.bulk_modulus_Pa / 2 * (J - 1) * (J - 1);
}

/// P = dW/dF.
inline Eigen::Matrix3d first_piola(const Material& m, const Eigen::Matrix3d& F) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), C = F.transpose() * F, F_T = F.inverse().transpose();
  const double mu = m.shear_modulus_Pa, lambda = m.lame_lambda_Pa, J = F.determinant();
  switch (m.law) {
    case Law::linear: {
      const Eigen::Matrix3d e = (F + F.transpose()) / 2 - I;
      return lambda * e.trace() * I + 2 * mu * e;
    }
    case Law::st_venant_kirchhoff: {
      const Eigen::Matrix3d E = (C - I) / 2;
      return F * (lambda * E.trace() * I + 2 * mu * E);
    }
    case Law::neo_hookean:
      return mu * (F - F_T) + lambda * std::log(J) * F_T;
    case Law::mooney_rivlin:
      break;
  }
  const double first = C.trace(), second = (first * first - C.squaredNorm()) / 2;
  return 2 * m.c10_Pa * std::pow(J, -2.0 / 3) * (F - first / 3 * F_T) +
         m.c01_Pa * std::pow(J, -4.0 / 3) * (2 * (first * F - F * C) - 4.0 / 3 * second * F_T) +
         m.bulk_modulus_Pa * (J - 1) * J * F_T;
}

}  // namespace phynness::test
