// How bounds of the force's error hold for solved displacements.
#pragma once

#include <array>
#include <cstdint>
#include <phynness/formats/described.hpp>
#include <vector>

namespace phynness {

/// A solved displacement inside the trained range.
struct BoundedError {
  std::int32_t node = 0;
  double depth_m = 0, error_N = 0, bound_N = 0;
  double largest_N = 0;  ///< force of the node to which its bounds are compared
  double weight = 1;     ///< number of nodes for which the node stands
};

/// Shares of the displacements whose error is at most the bound, by weight.
struct BoundCoverage {
  std::int64_t states = 0;
  double all = 0;
  std::array<double, 3> thirds{};    ///< of the depth; nan without states
  std::array<double, 4> quarters{};  ///< of the nodes, by the mean of bound over largest force; nan without states
  double width = 0;                  ///< mean bound over the best constant bound of the same coverage
  static void describe(const auto& c, auto&& see) {
    const auto known = [&](double value) { return c.states > 0 ? value : undefined; };
    see("coverage", known(c.all));
    see("thirds_of_depth", c.thirds);
    see("quarters_of_nodes", c.quarters);
    see("width_over_constant", known(c.width));
  }
};

/// @param range_m  length of which thirds are taken
BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m);

}  // namespace phynness
