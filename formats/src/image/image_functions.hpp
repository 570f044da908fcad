// The functions of phynness_image.h by the type of their numbers. A program has one type; the host, which writes and
// tests images of both, includes the header once for each.
#pragma once

#include <phynness/phynness_image.h>

#define PHYNNESS_IMAGE_FUNCTIONS                                   \
  template <>                                                      \
  struct Image<phn_real> {                                         \
    using Type = phn_image;                                        \
    using Place = phn_image_place;                                 \
    static constexpr auto open = phn_image_open;                   \
    static constexpr auto n_active = phn_image_n_active;           \
    static constexpr auto active_nodes = phn_image_active_nodes;   \
    static constexpr auto n_output = phn_image_n_output;           \
    static constexpr auto provenance = phn_image_provenance;       \
    static constexpr auto force = phn_image_force;                 \
    static constexpr auto energy = phn_image_energy;               \
    static constexpr auto stiffness = phn_image_stiffness;         \
    static constexpr auto trained_depth = phn_image_trained_depth; \
    static constexpr auto scratch_size = phn_image_scratch_size;   \
    static constexpr auto deform = phn_image_deform;               \
    static constexpr auto nearest = phn_image_nearest;             \
    static constexpr auto force_at = phn_image_force_at;           \
    static constexpr auto energy_at = phn_image_energy_at;         \
    static constexpr auto stiffness_at = phn_image_stiffness_at;   \
    static constexpr auto bound_at = phn_image_bound_at;           \
  };

namespace phynness {

template <class Real>
struct Image;

PHYNNESS_IMAGE_FUNCTIONS

}  // namespace phynness

#define PHYNNESS_IMAGE_FLOAT
#undef PHYNNESS_IMAGE_H
#include <phynness/phynness_image.h>

namespace phynness {

PHYNNESS_IMAGE_FUNCTIONS
#undef PHYNNESS_IMAGE_FUNCTIONS

}  // namespace phynness
