// Work along closed paths, integrated from forces.
#pragma once

#include <phynness/validation/validation.hpp>

namespace phynness::report {

struct Conservation {
  int paths = 0;
  double median = 0, largest = 0;  ///< |work| over the largest energy at a corner of the path
  bool has_energy = false;         ///< false: over the largest |force . d| / 2
};

/// Closed quadrilaterals of displacements inside the trained range at random nodes, with Gauss-Legendre quadrature
/// along each side.
Conservation closed_paths(const LoadedModel& model, int n_paths, std::uint64_t seed);

}  // namespace phynness::report
