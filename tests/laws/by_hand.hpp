// Comparison of an independently written law with the declaration in its file.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "solver_cases.hpp"

namespace phynness::test {

/// At rest, stretched, sheared and turned; det F > 0.
inline std::array<Eigen::Matrix3d, 4> some_states() {
  Eigen::Matrix3d stretched, sheared, turned;
  stretched << 1.3, 0, 0, 0, 0.9, 0, 0, 0, 0.8;
  sheared << 1.1, 0.3, -0.1, 0.05, 0.95, 0.2, -0.15, 0.1, 1.05;
  turned = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix() * sheared;
  return {Eigen::Matrix3d::Identity(), stretched, sheared, turned};
}

/// Energy and stress agree to rounding: a few dozen operations on numbers of the size of K. `first_piola` is
/// what a hand derives from W; the declared energy is differentiated by complex steps.
inline void expect_declared_as(const Material& material, const std::function<double(const Eigen::Matrix3d&)>& energy,
                               const std::function<Eigen::Matrix3d(const Eigen::Matrix3d&)>& stress) {
  const double tolerance = 1e-14 * material.bulk_modulus_Pa;
  for (const auto& F : some_states()) {
    EXPECT_NEAR(energy_density(material, F), energy(F), tolerance) << F;
    const Eigen::Matrix3d P = stress(F);
    EXPECT_LT((first_piola(material, F) - P).norm(), 10 * tolerance) << F << "\n" << P;
  }
}

}  // namespace phynness::test
