// The functions of an image by the type of its numbers.
#pragma once

#include <phynness/phynness_image.h>

#include <cstddef>

namespace phynness::test {

template <class Real>
struct Image;
template <>
struct Image<double> {
  using Type = phn_image;
  static constexpr auto open = phn_image_open;
  static constexpr auto force = phn_image_force;
  static constexpr auto energy = phn_image_energy;
  static constexpr auto stiffness = phn_image_stiffness;
  static constexpr auto trained_depth = phn_image_trained_depth;
  static std::size_t scratch(const Type* image) { return phn_image_scratch_size(image) / sizeof(double); }
  static constexpr auto deform = phn_image_deform;
  static constexpr auto n_active = phn_image_n_active;
  static constexpr auto active_nodes = phn_image_active_nodes;
  static constexpr auto n_output = phn_image_n_output;
  static constexpr auto provenance = phn_image_provenance;
  using Place = phn_image_place;
  static constexpr auto nearest = phn_image_nearest;
  static constexpr auto force_at = phn_image_force_at;
  static constexpr auto energy_at = phn_image_energy_at;
  static constexpr auto stiffness_at = phn_image_stiffness_at;
  static constexpr auto bound_at = phn_image_bound_at;
};
template <>
struct Image<float> {
  using Type = phn_imagef;
  static constexpr auto open = phn_imagef_open;
  static constexpr auto force = phn_imagef_force;
  static constexpr auto energy = phn_imagef_energy;
  static constexpr auto stiffness = phn_imagef_stiffness;
  static constexpr auto trained_depth = phn_imagef_trained_depth;
  static std::size_t scratch(const Type* image) { return phn_imagef_scratch_size(image) / sizeof(float); }
  static constexpr auto deform = phn_imagef_deform;
  static constexpr auto n_active = phn_imagef_n_active;
  static constexpr auto active_nodes = phn_imagef_active_nodes;
  static constexpr auto n_output = phn_imagef_n_output;
  static constexpr auto provenance = phn_imagef_provenance;
  using Place = phn_imagef_place;
  static constexpr auto nearest = phn_imagef_nearest;
  static constexpr auto force_at = phn_imagef_force_at;
  static constexpr auto energy_at = phn_imagef_energy_at;
  static constexpr auto stiffness_at = phn_imagef_stiffness_at;
  static constexpr auto bound_at = phn_imagef_bound_at;
};

}  // namespace phynness::test
