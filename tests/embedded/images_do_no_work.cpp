// Claim: forces of images around a closed loop do no work, relative to the largest energy stored on the way, in doubles
// and in floats. Tolerance and quadrature as in tests/runtime/closed_loops_do_no_work.cpp: found 2e-15 in
// double, 1.4e-7 in float; 1e-12 and 1e-5 are what is asked for.
#include <gtest/gtest.h>

#include "../runtime/closed_loop.hpp"
#include "opened_image.hpp"

namespace phynness::test {
namespace {

using Eigen::Vector3d;

/// For a node with 40 centers in the ball of radius 1, as training makes them.
template <class Real>
double worst_loop_in() {
  ImageOptions options;
  options.floats = sizeof(Real) == sizeof(float);
  const OpenedImage<Real> opened(model_image(small_modal_model(3, 40), options));
  const double R = 0.01;
  const auto displacement = [&](const Vector3d& x) -> Eigen::Matrix<Real, 3, 1> { return (R * x).cast<Real>(); };
  return worst_loop(
      [&](const Vector3d& x) {
        Eigen::Matrix<Real, 3, 1> force;
        EXPECT_GE(Image<Real>::force(opened.image, 3, displacement(x).data(), force.data()), 0);
        return Vector3d(R * force.template cast<double>());
      },
      [&](const Vector3d& x) {
        Real energy = 0;
        EXPECT_GE(Image<Real>::energy(opened.image, 3, displacement(x).data(), &energy), 0);
        return static_cast<double>(energy);
      });
}

TEST(Images, DoNoWorkAlongClosedLoops) {
  EXPECT_LT(worst_loop_in<double>(), 1e-12);
  EXPECT_LT(worst_loop_in<float>(), 1e-5);
}

}  // namespace
}  // namespace phynness::test
