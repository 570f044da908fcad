// The surface of an image (runtime/include/phynness/image_layout.hpp), in double.
#pragma once

#include <phynness/formats/model.hpp>
#include <phynness/image_layout.hpp>

namespace phynness {

/// As image::Surface, without bounds.
struct ImageSurface {
  std::vector<std::uint16_t> triangle, neighbour;
  std::vector<image::VertexCorners> vertex;
  std::vector<std::uint32_t> begin;
  Points point, slope;
};
/// The triangles where a tool can be, because each corner is active, covered or fixed, and one is not fixed. None if
/// the tools are not round.
/// @throws Error (input) if there are more than 16-bit numbers can count
ImageSurface image_surface(const Model& model);

}  // namespace phynness
