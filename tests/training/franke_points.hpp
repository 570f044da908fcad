// Franke's test function (NPS-53-79-003, 1979) on Halton points (Numer. Math. 2, 84, 1960; bases 2 and 3).
#pragma once

#include <cmath>
#include <phynness/training/network_fit.hpp>

namespace phynness::test {

inline double franke(double x, double y) {
  const double a = 9 * x, b = 9 * y;
  return 0.75 * std::exp(-((a - 2) * (a - 2) + (b - 2) * (b - 2)) / 4) +
         0.75 * std::exp(-(a + 1) * (a + 1) / 49 - (b + 1) / 10) +
         0.5 * std::exp(-((a - 7) * (a - 7) + (b - 3) * (b - 3)) / 4) -
         0.2 * std::exp(-(a - 4) * (a - 4) - (b - 7) * (b - 7));
}

inline double radical_inverse(int i, int base) {
  double value = 0, digit = 1.0 / base;
  for (; i > 0; i /= base, digit /= base) value += digit * (i % base);
  return value;
}

/// The first n Halton points of the unit square; outputs: Franke's function, its mirror image, and their
/// product.
inline NetworkPoints franke_points(int n) {
  NetworkPoints points;
  points.displacements.resize(n, 2);
  points.outputs.resize(n, 3);
  for (int i = 0; i < n; ++i) {
    const double x = radical_inverse(i + 1, 2), y = radical_inverse(i + 1, 3);
    points.displacements.row(i) << x, y;
    points.displacement.push_back(i);
    points.outputs.row(i) << franke(x, y), franke(1 - x, y), franke(x, y) * franke(1 - x, y);
  }
  return points;
}

/// Root mean square error of the first output on a 41 x 41 grid of the unit square.
template <class Function>
double grid_error(const Function& approximation) {
  double sum = 0;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 40; ++j) {
      const double x = i / 40.0, y = j / 40.0;
      sum += std::pow(approximation(x, y) - franke(x, y), 2);
    }
  }
  return std::sqrt(sum / (41 * 41));
}

}  // namespace phynness::test
