// Detection and removal of intersections of a surface with itself, which no mesher can fill.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "surface.hpp"

namespace phynness::meshes {

/// Pairs of intersecting triangles, smaller number first, sorted. Triangles that only share a node or an edge do not
/// count unless they also intersect elsewhere.
std::vector<std::array<std::int32_t, 2>> crossing_triangles(const Surface& surface);

/// Smooths the surface around its intersections, in growing neighbourhoods, until there are none. `notes` describes the
/// changes. A surface without intersections is not changed.
/// @throws Error (failure) with the remaining pairs if smoothing does not help
void untangle(Surface& surface, std::vector<std::string>& notes);

}  // namespace phynness::meshes
