// Shaded triangles of a surface with their edges, as SVG.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <string>

namespace phynness::report {

/// View along the shortest axis of the body. There is one path for each of some shades, which keeps tens of thousands
/// of triangles below a megabyte. @param points  n x 3
std::string mesh_picture(const Points& points, const Triangles& triangles);

}  // namespace phynness::report
