#include "plain_runtime.hpp"

#include <cmath>

namespace phynness::bench {
namespace {

template <int N, class Real>
void evaluate(const PlainNetwork<N, Real>& net, const Real* x, Real* y) {
  for (int k = 0; k < 3; ++k) y[k] = net.bias[k];
  for (const auto& neuron : net.neurons) {
    Real square = 0;
    for (int k = 0; k < N; ++k) square += (x[k] - neuron.center[k]) * (x[k] - neuron.center[k]);
    const Real h = std::exp(-square / (net.spread * net.spread));
    for (int k = 0; k < 3; ++k) y[k] += neuron.weight[k] * h;
  }
}

}  // namespace

void plain_force(const PlainNetwork<3>& net, const double* d, double* force) { evaluate(net, d, force); }
void plain_force(const PlainNetwork<3, float>& net, const float* d, float* force) { evaluate(net, d, force); }

void plain_deformation(const PlainNetwork<6>& net, const std::vector<std::array<double, 3>>& points,
                       const double* d, double* field) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x[6] = {d[0], d[1], d[2], points[i][0], points[i][1], points[i][2]};
    evaluate(net, x, field + 3 * i);
  }
}

}  // namespace phynness::bench
