// Baseline for the runtime: the loops over (11)-(12) with the usual optimizations. There is one array per input and
// component, no division in the loop, and partial sums that the compiler can keep in registers. The same source is
// compiled twice:
// - textbook_loops: -O3 -march=native, with one call of the C library's exponential for each value;
// - fast_math_loops: also -ffast-math, with reordered sums and the exponential of libmvec for whole registers. Its
//   results depend on processor, compiler and library; those of the runtime do not.
#pragma once

#include <array>
#include <vector>

namespace phynness::bench {

/// Gaussian network (11)-(12) of N inputs that are scaled to [-1, 1]. At most 1024 neurons.
template <int N, class Real = double>
struct PlainNetwork {
  std::array<std::vector<Real>, N> center;
  std::array<std::vector<Real>, 3> weight;
  std::array<Real, 3> bias{};
  Real spread = 1;
};

/// @tparam Real  double or float
template <class Real>
struct PlainLoops {
  using Points = std::vector<std::array<Real, 3>>;
  void (*force)(const PlainNetwork<3, Real>& net, const Real* d, Real* force);
  /// The network without precomputed tables: n_points x n_neurons exponentials.
  /// @param field  n_points x 3
  void (*deformation)(const PlainNetwork<6, Real>& net, const Points& points, const Real* d, Real* field);
  /// The factors of the Gaussians that depend only on the points, as exp(a + b) = exp(a) exp(b).
  /// @param table  n_neurons x n_points
  void (*tabulate)(const PlainNetwork<6, Real>& net, const Points& points, Real* table);
  /// With the table: n_neurons exponentials. @param sums  scratch, 3 x n_points
  void (*tabulated_deformation)(const PlainNetwork<6, Real>& net, int n_points, const Real* table, const Real* d,
                                Real* sums, Real* field);
};

template <class Real>
const PlainLoops<Real>& textbook_loops();
template <class Real>
const PlainLoops<Real>& fast_math_loops();

}  // namespace phynness::bench
