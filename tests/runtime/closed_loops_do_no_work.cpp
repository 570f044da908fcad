#include <gtest/gtest.h>

#include "../embedded/opened_image.hpp"
#include "loaded_model.hpp"
#include "rounding.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Vector3d;

// Gauss-Legendre points and weights on [-1, 1], ten points.
constexpr double gauss_point[] = {0.14887433898163121, 0.43339539412924719, 0.67940956829902441, 0.86506336668898451,
                                  0.97390652851717172};
constexpr double gauss_weight[] = {0.29552422471475287, 0.26926671930999636, 0.21908636251598204, 0.14945134915058059,
                                   0.06667134430868814};

/// Work of force(x), in units of R, along closed polygons of 3 to 6 corners, over the largest energy on each;
/// the worst of 1,000.
template <class Force, class Energy>
double worst_loop(Force force, Energy energy) {
  constexpr int n_parts = 8;
  Numbers numbers;
  double worst = 0;
  for (int loop = 0; loop < 1000; ++loop) {
    std::vector<Vector3d> corners(3 + loop % 4);
    for (Vector3d& corner : corners) corner = numbers.vector();
    double work = 0, stored = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector3d step = (corners[(i + 1) % corners.size()] - corners[i]) / n_parts;
      for (int part = 0; part < n_parts; ++part) {
        const Vector3d middle = corners[i] + (part + 0.5) * step;
        stored = std::max(stored, energy(middle));
        for (int p = 0; p < 5; ++p) {
          for (const double t : {gauss_point[p], -gauss_point[p]})
            work += gauss_weight[p] / 2 * force(Vector3d(middle + t / 2 * step)).dot(step);
        }
      }
    }
    worst = std::max(worst, std::abs(work) / stored);
  }
  return worst;
}

/// In an image of a node with 40 centers in the ball of radius 1, as training makes them.
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

// Claim: forces around a closed loop do no work, relative to the largest energy stored on the way, in images of
// doubles and of floats. Ten points on each eighth of an edge integrate exactly but for 4e-15 (halving the pieces
// changes nothing, doubling gives 1e-9), so the rest is rounding: found FOUND_DOUBLE in double, FOUND_FLOAT in float;
// 1e-12 and 1e-5 are what is asked for.
TEST(ClosedLoops, DoNoWork) {
  EXPECT_LT(worst_loop_in<double>(), 1e-12);
  EXPECT_LT(worst_loop_in<float>(), 1e-5);
}

// Claim: the same through the C interface, for every node of a model; found 4e-8 in the runtime of floats.
TEST(ClosedLoops, DoNoWorkThroughTheInterface) {
  const Model model = small_modal_model();
  const LoadedModel loaded(write_model_text(model));
  const double R = model.max_displacement_m;
  for (const ActiveNodeModel& node : model.nodes) {
    EXPECT_LT(worst_loop(
                  [&](const Vector3d& x) {
                    const Vector3d d = R * x;
                    Vector3d force;
                    EXPECT_GE(phn_force(loaded.model, loaded.data, node.node, d.data(), force.data(), nullptr, nullptr),
                              0);
                    return Vector3d(R * force);
                  },
                  [&](const Vector3d& x) {
                    const Vector3d d = R * x;
                    double energy = 0;
                    EXPECT_GE(phn_force(loaded.model, loaded.data, node.node, d.data(), nullptr, &energy, nullptr), 0);
                    return energy;
                  }),
              in_float ? 1e-5 : 1e-12);
  }
}

}  // namespace
