// The functions of phynness_image.h for each type of numbers.
#pragma once

#include <phynness/phynness_image.h>

namespace phynness {

#define PHYNNESS_IMAGE_FUNCTIONS(Name, Number, NAME)      \
  struct Name {                                           \
    using Real = Number;                                  \
    using Image = NAME;                                   \
    using Place = NAME##_place;                           \
    static constexpr auto open = NAME##_open;             \
    static constexpr auto force = NAME##_force;           \
    static constexpr auto energy = NAME##_energy;         \
    static constexpr auto deform = NAME##_deform;         \
    static constexpr auto n_active = NAME##_n_active;     \
    static constexpr auto n_output = NAME##_n_output;     \
    static constexpr auto provenance = NAME##_provenance; \
    static constexpr auto nearest = NAME##_nearest;       \
    static constexpr auto force_at = NAME##_force_at;     \
    static constexpr auto bound_at = NAME##_bound_at;     \
  };
PHYNNESS_IMAGE_FUNCTIONS(DoubleImage, double, phn_image)
PHYNNESS_IMAGE_FUNCTIONS(FloatImage, float, phn_imagef)
#undef PHYNNESS_IMAGE_FUNCTIONS

}  // namespace phynness
