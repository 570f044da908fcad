// [mesh] symmetry: a plane of symmetry of the body.
#include <cmath>

#include "scene_sections.hpp"

namespace phynness::scene_detail {
namespace {

/// "x", "y" or "z": the centre plane of the bounding box perpendicular to this axis.
SymmetryPlane centre_plane(const SceneTable& mesh, const std::string& axis) {
  SymmetryPlane plane;
  if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z')
    mesh.reject("symmetry", "is not a known plane",
                "write \"x\", \"y\" or \"z\" (the centre plane perpendicular to this axis), or { point_m = [...], "
                "normal = [...] }");
  plane.normal[static_cast<std::size_t>(axis[0] - 'x')] = 1;
  return plane;
}

void check_use(const SceneTable& mesh, const SymmetryPlane& plane) {
  if (mesh.has("file")) {
    if (plane.half && plane.fraction)
      mesh.reject("symmetry", "with half = true needs a plane in metres",
                  "give point_m instead of point_fraction, which would refer to the half");
    return;
  }
  const bool is_axis =
      std::abs(plane.normal[0]) == 1 || std::abs(plane.normal[1]) == 1 || std::abs(plane.normal[2]) == 1;
  const bool is_centre = plane.fraction && plane.point == SymmetryPlane{}.point;
  if (mesh.text("shape") == "liver")
    mesh.reject("symmetry", "is given, but the built-in liver has no plane of symmetry", "remove it");
  if (!is_axis || !is_centre)
    mesh.reject("symmetry", "is not a centre plane, but built-in shapes are symmetric about their centre planes only",
                "write symmetry = \"x\", \"y\" or \"z\"");
  if (plane.half)
    mesh.reject("symmetry", "has half = true, which is only for mesh files",
                "remove half; a built-in shape is complete");
}

}  // namespace

SymmetryPlane parse_symmetry(const SceneTable& mesh) {
  const auto* node = mesh.find("symmetry");
  SymmetryPlane plane;
  if (const auto* word = node->as_string()) {
    plane = centre_plane(mesh, word->get());
  } else if (const auto* inner = node->as_table()) {
    const SceneTable table(*inner, "mesh.symmetry", mesh.file());
    if (table.has("point_m") || table.has("point_fraction"))
      plane.point = parse_position(table, "point", plane.fraction);
    plane.normal = parse_normal(table);
    plane.tolerance_m = table.number_or("tolerance_m", 0, {0, 1e3, true, false});
    plane.half = table.flag_or("half", false);
  } else {
    mesh.reject("symmetry", "must be text or a table", "write \"x\", or { point_m = [0, 0, 0], normal = [1, 0, 0] }");
  }
  plane.where = mesh.where("symmetry");
  check_use(mesh, plane);
  return plane;
}

}  // namespace phynness::scene_detail
