// The unit of printed forces: the forces of soft, thin bodies are of the order of micronewtons.
#pragma once

namespace phynness {

struct ForceUnit {
  double per_N;
  const char* name;
};

/// Micronewtons if millinewtons would show no digits of the largest force, otherwise millinewtons.
inline ForceUnit force_unit(double largest_N) { return largest_N < 1e-4 ? ForceUnit{1e6, "uN"} : ForceUnit{1e3, "mN"}; }

}  // namespace phynness
