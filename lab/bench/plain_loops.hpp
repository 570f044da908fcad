// The loops of plain_runtime.hpp, included by each file that compiles them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "plain_runtime.hpp"

namespace phynness::bench {
namespace {

constexpr int most_neurons = 1024, partial_sums = 16;

/// exp(-|x - c|^2 / spread^2) over the inputs `first` ... `first` + n_inputs - 1.
template <int n_inputs, int N, class Real>
void gaussians(const PlainNetwork<N, Real>& net, int first, const Real* input, Real* h) {
  const int n = static_cast<int>(net.weight[0].size());
  const Real scale = -1 / (net.spread * net.spread);
  const Real* c[n_inputs];
  Real x[n_inputs];
  for (int k = 0; k < n_inputs; ++k) {
    c[k] = net.center[static_cast<std::size_t>(first + k)].data();
    x[k] = input[k];
  }
  for (int i = 0; i < n; ++i) {
    Real square = 0;
    for (int k = 0; k < n_inputs; ++k) square += (x[k] - c[k][i]) * (x[k] - c[k][i]);
    h[i] = square * scale;
  }
  for (int i = 0; i < n; ++i) h[i] = std::exp(h[i]);
}

template <int N, class Real>
void evaluate(const PlainNetwork<N, Real>& net, const Real* x, Real* y) {
  const int n = static_cast<int>(net.weight[0].size());
  Real h[most_neurons];
  gaussians<N>(net, 0, x, h);
  for (std::size_t k = 0; k < 3; ++k) {
    const Real* w = net.weight[k].data();
    Real sums[partial_sums] = {}, total = net.bias[k];
    int i = 0;
    for (; i + partial_sums <= n; i += partial_sums)
      for (int j = 0; j < partial_sums; ++j) sums[j] += w[i + j] * h[i + j];
    for (; i < n; ++i) total += w[i] * h[i];
    for (int j = 0; j < partial_sums; ++j) total += sums[j];
    y[k] = total;
  }
}

template <class Real>
void deformation(const PlainNetwork<6, Real>& net, const typename PlainLoops<Real>::Points& points, const Real* d,
                 Real* field) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Real x[6] = {d[0], d[1], d[2], points[i][0], points[i][1], points[i][2]};
    evaluate(net, x, field + 3 * i);
  }
}

template <class Real>
void tabulate(const PlainNetwork<6, Real>& net, const typename PlainLoops<Real>::Points& points, Real* table) {
  Real h[most_neurons];
  for (std::size_t p = 0; p < points.size(); ++p) {
    gaussians<3>(net, 3, points[p].data(), h);
    for (std::size_t i = 0; i < net.weight[0].size(); ++i) table[i * points.size() + p] = h[i];
  }
}

template <class Real>
void tabulated_deformation(const PlainNetwork<6, Real>& net, int n_points, const Real* __restrict table, const Real* d,
                           Real* __restrict sums, Real* __restrict field) {
  Real h[most_neurons];
  gaussians<3>(net, 0, d, h);
  Real *x = sums, *y = sums + n_points, *z = sums + 2 * n_points;
  for (int k = 0; k < 3; ++k) std::fill_n(sums + k * n_points, n_points, net.bias[static_cast<std::size_t>(k)]);
  for (std::size_t i = 0; i < net.weight[0].size(); ++i, table += n_points) {
    const Real a = net.weight[0][i] * h[i], b = net.weight[1][i] * h[i], c = net.weight[2][i] * h[i];
    for (int p = 0; p < n_points; ++p) {
      x[p] += a * table[p];
      y[p] += b * table[p];
      z[p] += c * table[p];
    }
  }
  for (int p = 0; p < n_points; ++p) {
    field[3 * p] = x[p];
    field[3 * p + 1] = y[p];
    field[3 * p + 2] = z[p];
  }
}

template <class Real>
constexpr PlainLoops<Real> loops = {evaluate<3, Real>, deformation<Real>, tabulate<Real>, tabulated_deformation<Real>};

}  // namespace
}  // namespace phynness::bench
