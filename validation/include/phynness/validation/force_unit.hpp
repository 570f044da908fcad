// The unit in which people read forces: soft thin bodies answer with micronewtons.
#pragma once

namespace phynness {

struct ForceUnit {
  double per_N;
  const char* name;
};

/// Micronewtons where millinewtons would show no digits of the largest force, else millinewtons.
inline ForceUnit force_unit(double largest_N) { return largest_N < 1e-4 ? ForceUnit{1e6, "uN"} : ForceUnit{1e3, "mN"}; }

}  // namespace phynness
