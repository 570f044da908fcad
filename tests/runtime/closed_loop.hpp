// Work along closed paths.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "small_model.hpp"

namespace phynness::test {

// Gauss-Legendre points and weights on [-1, 1], ten points.
inline constexpr double gauss_point[] = {0.14887433898163121, 0.43339539412924719, 0.67940956829902441,
                                         0.86506336668898451, 0.97390652851717172};
inline constexpr double gauss_weight[] = {0.29552422471475287, 0.26926671930999636, 0.21908636251598204,
                                          0.14945134915058059, 0.06667134430868814};

/// Work of force(x), in units of R, along closed polygons of 3 to 6 corners, over the largest energy on each;
/// the worst of 1,000.
template <class Force, class Energy>
double worst_loop(Force force, Energy energy) {
  constexpr int n_parts = 8;
  Numbers numbers;
  double worst = 0;
  for (int loop = 0; loop < 1000; ++loop) {
    std::vector<Eigen::Vector3d> corners(3 + loop % 4);
    for (Eigen::Vector3d& corner : corners) corner = numbers.vector();
    double work = 0, stored = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector3d step = (corners[(i + 1) % corners.size()] - corners[i]) / n_parts;
      for (int part = 0; part < n_parts; ++part) {
        const Eigen::Vector3d middle = corners[i] + (part + 0.5) * step;
        stored = std::max(stored, energy(middle));
        for (int p = 0; p < 5; ++p) {
          for (const double t : {gauss_point[p], -gauss_point[p]})
            work += gauss_weight[p] / 2 * force(Eigen::Vector3d(middle + t / 2 * step)).dot(step);
        }
      }
    }
    worst = std::max(worst, std::abs(work) / stored);
  }
  return worst;
}

}  // namespace phynness::test
