// How bounds of the force's error hold for solved displacements.
#pragma once

#include <array>
#include <cstdint>
#include <phynness/formats/described.hpp>
#include <vector>

namespace phynness {

/// A solved displacement inside the trained range.
struct BoundedError {
  double depth_m = 0, error_N = 0, bound_N = 0;
  double weight = 1;  ///< number of nodes for which the node stands
};

/// Shares of the displacements whose error is at most the bound, by weight.
struct BoundCoverage {
  std::int64_t states = 0;
  double all = 0;
  std::array<double, 3> thirds{};  ///< of the depth; nan without states
  static void describe(const auto& c, auto&& see) {
    see("states", c.states);
    see("coverage", c.states > 0 ? c.all : undefined);
    see("thirds_of_depth", c.thirds);
  }
};

/// @param range_m  length of which thirds are taken
BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m);

/// The share of fresh errors below a bound that 19 calibrations of 20 reach or exceed. The bound is the k-th smallest
/// of n independent errors over their prediction, k = ceil(coverage (n + 1)), and the share of fresh ones below has the
/// distribution Beta(k, n + 1 - k) (Vovk 2012, arXiv:1209.2673). Errors of one place count as one, because they are
/// alike.
/// @param n  number of places, or of rays. @return 0 if n is too small for a bound
double promised_coverage(std::int64_t n, double coverage);

}  // namespace phynness
