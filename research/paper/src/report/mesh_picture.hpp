// A surface's triangles, lit and with their edges, as SVG.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <string>

namespace phynness::report {

/// Seen along the body's shortest axis. One path for each of some shades, so that tens of thousands of
/// triangles stay below a megabyte. @param points  n x 3; @param caption  HTML
std::string mesh_picture(const Points& points, const Triangles& triangles, const std::string& caption);

}  // namespace phynness::report
