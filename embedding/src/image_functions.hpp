// The functions of phynness_image.h for each type of numbers.
#pragma once

#include <phynness/phynness_image.h>

namespace phynness {

struct DoubleImage {
  using Real = double;
  using Image = phn_image;
  static constexpr auto open = phn_image_open;
  static constexpr auto force = phn_image_force;
  static constexpr auto energy = phn_image_energy;
  static constexpr auto deform = phn_image_deform;
  static constexpr auto n_active = phn_image_n_active;
  static constexpr auto n_output = phn_image_n_output;
  static constexpr auto provenance = phn_image_provenance;
  using Place = phn_image_place;
  static constexpr auto nearest = phn_image_nearest;
  static constexpr auto force_at = phn_image_force_at;
  static constexpr auto bound_at = phn_image_bound_at;
};
struct FloatImage {
  using Real = float;
  using Image = phn_imagef;
  static constexpr auto open = phn_imagef_open;
  static constexpr auto force = phn_imagef_force;
  static constexpr auto energy = phn_imagef_energy;
  static constexpr auto deform = phn_imagef_deform;
  static constexpr auto n_active = phn_imagef_n_active;
  static constexpr auto n_output = phn_imagef_n_output;
  static constexpr auto provenance = phn_imagef_provenance;
  using Place = phn_imagef_place;
  static constexpr auto nearest = phn_imagef_nearest;
  static constexpr auto force_at = phn_imagef_force_at;
  static constexpr auto bound_at = phn_imagef_bound_at;
};

}  // namespace phynness
