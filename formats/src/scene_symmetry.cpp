// [mesh] symmetry: a plane in which the body is its own mirror image.
#include <cmath>

#include "scene_keys.hpp"
#include "scene_sections.hpp"

namespace phynness::scene_detail {
namespace {

/// "x", "y" or "z": the centre plane of the bounding box across that axis.
SymmetryPlane centre_plane(const SceneTable& mesh, const std::string& axis) {
  SymmetryPlane plane;
  if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z')
    mesh.reject("symmetry", "names no plane",
                "write \"x\", \"y\" or \"z\" (the centre plane across that axis), or { point_m = [...], normal = "
                "[...] }");
  plane.normal[static_cast<std::size_t>(axis[0] - 'x')] = 1;
  return plane;
}

void check_use(const SceneTable& mesh, const SymmetryPlane& plane) {
  if (mesh.has("file")) {
    if (plane.half && plane.fraction)
      mesh.reject("symmetry", "mirrors half a body in a plane that is not given in metres",
                  "give point_m: fractions would be those of the half");
    return;
  }
  const bool is_axis =
      std::abs(plane.normal[0]) == 1 || std::abs(plane.normal[1]) == 1 || std::abs(plane.normal[2]) == 1;
  const bool is_centre = plane.fraction && plane.point == SymmetryPlane{}.point;
  if (mesh.text("shape") == "liver")
    mesh.reject("symmetry", "is declared, but the built-in liver has no plane of symmetry", "remove it");
  if (!is_axis || !is_centre)
    mesh.reject("symmetry", "is no centre plane, and built-in shapes are symmetric in those",
                "write symmetry = \"x\", \"y\" or \"z\"");
  if (plane.half)
    mesh.reject("symmetry", "has half = true, which is for mesh files", "remove half: a built-in shape is whole");
}

}  // namespace

std::optional<SymmetryPlane> parse_symmetry(const SceneTable& mesh) {
  const auto* node = mesh.find("symmetry");
  if (!node) return std::nullopt;
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
