#include "machine_limits.hpp"

#include <vector>

#include "median_time.hpp"

namespace phynness::bench {
namespace {

/// Registers of 64 bytes, or pairs and fours of smaller ones.
constexpr int n_chains = 8, n_steps = 2000;

template <class Vector, class Number>
double gflops() {
  constexpr int lanes = sizeof(Vector) / sizeof(Number);
  Vector sums[n_chains];
  volatile Number start = Number(0.5);
  for (auto& sum : sums) sum = Vector{} + start;
  const Vector factor = Vector{} + start, term = Vector{} + start;
  const double us = median_us([&](int) {
    Vector x[n_chains];
    for (int c = 0; c < n_chains; ++c) x[c] = sums[c];
    // Chains that wait for nothing but themselves: both units are busy.
    for (int i = 0; i < n_steps; ++i) {
      for (int c = 0; c < n_chains; ++c) x[c] = x[c] * factor + term;
    }
    for (int c = 0; c < n_chains; ++c) sums[c] = x[c];
  });
  volatile Number keep = sums[0][0] + sums[n_chains - 1][lanes - 1];
  static_cast<void>(keep);
  return 1e-3 * 2.0 * n_chains * lanes * n_steps / us;
}

using Doubles = double __attribute__((vector_size(64)));
using Floats = float __attribute__((vector_size(64)));

}  // namespace

MachineLimits machine_limits() { return {gflops<Doubles, double>(), gflops<Floats, float>()}; }

double read_rate(std::size_t bytes) {
  std::vector<Doubles> data(bytes / sizeof(Doubles));
  for (auto& entry : data) entry = Doubles{} + 1e-300;
  Doubles sum[4] = {};
  const double us = median_us([&](int) {
    for (std::size_t i = 0; i + 4 <= data.size(); i += 4) {
      for (std::size_t k = 0; k < 4; ++k) sum[k] += data[i + k];
    }
  });
  volatile double keep = sum[0][0] + sum[1][1] + sum[2][2] + sum[3][3];
  static_cast<void>(keep);
  return 1e-3 * static_cast<double>(bytes) / us;
}

}  // namespace phynness::bench
