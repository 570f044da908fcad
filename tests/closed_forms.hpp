// Energy density, first Piola-Kirchhoff stress and mean pressure of each law in plain numbers, from the energy that its
// file declares, without UFL, its derivatives or compiled kernels. The test of each law, tests/laws/NAME.cpp, checks
// the declared energy itself.
#pragma once

#include <Eigen/Dense>
#include <complex>
#include <phynness/formats/scene.hpp>
#include <vector>

namespace phynness::test {

struct DeclaredLaw {
  double (*energy)(const Eigen::Matrix3d& F, const double* parameters);  ///< W(F), per reference volume
  std::complex<double> (*complex_energy)(const Eigen::Matrix3cd& F, const double* parameters);
  double (*pressure)(const Eigen::Matrix3d& F, const double* parameters);  ///< kappa g(F)
  /// Positive where the energy is defined, in addition to det F > 0; null where nothing is added.
  double (*inside)(const Eigen::Matrix3d& F, const double* parameters);
  std::vector<double> (*example)(double K);  ///< parameters with mu = 1
};
/// The build makes them: declared_laws.cpp of laws/tables/tables.py.
const DeclaredLaw& declared(Law law);

/// The pressure unknown of mixed elements in a homogeneous state: kappa g(F) of forms/mechanics.py.
inline double pressure(const Material& m, const Eigen::Matrix3d& F) {
  return declared(m.law).pressure(F, m.parameters.data());
}

/// W(F), energy per reference volume.
inline double energy_density(const Material& m, const Eigen::Matrix3d& F) {
  return declared(m.law).energy(F, m.parameters.data());
}

/// P = dW/dF by complex steps, W(F + i h E) = W(F) + i h dW/dF : E + O(h^2): no difference of near numbers,
/// so that h may be so small that the remainder vanishes and P is exact to rounding (Squire and Trapp 1998,
/// doi 10.1137/S003614459631241X).
inline Eigen::Matrix3d first_piola(const Material& m, const Eigen::Matrix3d& F) {
  constexpr double h = 1e-30;
  Eigen::Matrix3d P;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Eigen::Matrix3cd moved = F.cast<std::complex<double>>();
      moved(i, j) += std::complex<double>(0, h);
      P(i, j) = declared(m.law).complex_energy(moved, m.parameters.data()).imag() / h;
    }
  return P;
}

}  // namespace phynness::test
