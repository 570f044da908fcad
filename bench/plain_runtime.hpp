// What anybody would write first: neurons as structures, one loop. Compiled with -O3
// -march=native.
#pragma once

#include <array>
#include <vector>

namespace phynness::bench {

/// Gaussian network (11)-(12) of N inputs, scaled to [-1, 1] beforehand.
template <int N, class Real = double>
struct PlainNetwork {
  struct Neuron {
    std::array<Real, N> center;
    std::array<Real, 3> weight;
  };
  std::vector<Neuron> neurons;
  std::array<Real, 3> bias{};
  Real spread = 1;
};

void plain_force(const PlainNetwork<3>& net, const double* d, double* force);
void plain_force(const PlainNetwork<3, float>& net, const float* d, float* force);
/// @param points  n x 3; @param field n x 3
void plain_deformation(const PlainNetwork<6>& net, const std::vector<std::array<double, 3>>& points,
                       const double* d, double* field);

}  // namespace phynness::bench
