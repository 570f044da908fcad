// Responses of family linear in an image.
#pragma once

#include "image/view.hpp"

namespace PHN_IMAGES {

/// @param d  clamped, also in the functions below
inline void response_force(const Header&, const LinearResponse& linear, const Real* d, Real* force) {
  multiply_symmetric(linear.stiffness, d, force);
}

inline Real response_energy(const Header&, const LinearResponse& linear, const Real* d) {
  Real force[3];
  multiply_symmetric(linear.stiffness, d, force);
  return dot(d, force) / 2;
}

inline void response_stiffness(const Header&, const LinearResponse& linear, const Real*, Real* stiffness) {
  fill_symmetric(linear.stiffness, stiffness);
}

inline bool response_field(const Header& image, const LinearResponse& linear, const Real* d, Real*, Real* field) {
  const Real* unit = at<Real>(image, linear.unit_responses);
  for (uint32_t o = 0; o < image.output_nodes.n; ++o, unit += 9, field += 3)
    for (int k = 0; k < 3; ++k) field[k] = d[0] * unit[k] + d[1] * unit[3 + k] + d[2] * unit[6 + k];
  return true;
}

}  // namespace PHN_IMAGES
