// Surfaces that cut through themselves: no mesher can fill them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "surface.hpp"

namespace phynness::meshes {

/// Pairs of triangles that cut through each other, smaller number first, sorted. Triangles that only share a
/// node or an edge do not count unless they also cross elsewhere.
std::vector<std::array<std::int32_t, 2>> crossing_triangles(const Surface& surface);

/// Smooths the surface around its crossings, over a growing neighbourhood, until there are none. What was
/// done is named in `notes`; nothing happens to a surface without crossings.
/// @throws Error (failure) with the pairs that are left if smoothing does not help
void untangle(Surface& surface, std::vector<std::string>& notes);

}  // namespace phynness::meshes
