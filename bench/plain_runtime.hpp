// What the runtime is compared with: the loops over (11)-(12) that a textbook on performance arrives at
// within a page. One array per input and component, no division in the loop, partial sums that the compiler
// can keep in registers. The same source is compiled twice:
// - textbook_loops: -O3 -march=native, the exponential of the C library, one at a time;
// - fast_math_loops: -ffast-math as well, so that sums are reordered and the exponential comes from libmvec,
// for whole
//   registers. Its results depend on processor, compiler and library; the runtime's do not.
#pragma once

#include <array>
#include <vector>

namespace phynness::bench {

/// Gaussian network (11)-(12) of N inputs, scaled to [-1, 1] beforehand. At most 1024 neurons.
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
  /// The network as it stands: n_points x n_neurons exponentials.
  /// @param field  n_points x 3
  void (*deformation)(const PlainNetwork<6, Real>& net, const Points& points, const Real* d, Real* field);
  /// What of the Gaussians depends on the points alone, as exp(a + b) = exp(a) exp(b). @param table n_neurons
  /// x n_points
  void (*tabulate)(const PlainNetwork<6, Real>& net, const Points& points, Real* table);
  /// From the table: n_neurons exponentials. @param sums  scratch, 3 x n_points
  void (*tabulated_deformation)(const PlainNetwork<6, Real>& net, int n_points, const Real* table, const Real* d,
                                Real* sums, Real* field);
};

template <class Real>
const PlainLoops<Real>& textbook_loops();
template <class Real>
const PlainLoops<Real>& fast_math_loops();

}  // namespace phynness::bench
