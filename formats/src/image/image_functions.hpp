// The interface of phynness_image.h by the type of its numbers. A program has one type; the host, which writes and
// tests images of both, includes the header once for each.
#pragma once

#include <phynness/phynness_image.h>

#define PHYNNESS_IMAGE_FUNCTIONS                           \
  template <>                                              \
  struct Image<phn_real> {                                 \
    using Type = phn_image;                                \
    using Contents = phn_image_contents;                   \
    using Tool = phn_image_tool;                           \
    static constexpr auto tool_at = phn_image_tool_at;     \
    static constexpr auto open = phn_image_open;           \
    static constexpr auto info = phn_image_info;           \
    static constexpr auto nearest = phn_image_nearest;     \
    static constexpr auto force = phn_image_force;         \
    static constexpr auto energy = phn_image_energy;       \
    static constexpr auto stiffness = phn_image_stiffness; \
    static constexpr auto depth = phn_image_depth;         \
    static constexpr auto bound = phn_image_bound;         \
    static constexpr auto deform = phn_image_deform;       \
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
