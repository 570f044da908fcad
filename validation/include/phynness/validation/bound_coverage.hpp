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

}  // namespace phynness
