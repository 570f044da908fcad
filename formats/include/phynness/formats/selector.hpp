// Selections of mesh nodes and cells as a scene describes them. resolve_selections() and cell_regions() of meshes/ find
// them on a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace phynness {

/// Position of a value in a scene file, for messages: "file.toml:12".
struct SourceLocation {
  std::string file;
  int line = 0;
  std::string str() const { return file + ":" + std::to_string(line); }
  /// "file.toml:12: " for the beginning of a message; empty without a file.
  std::string prefix() const { return file.empty() ? "" : str() + ": "; }
};

using Vec3 = std::array<double, 3>;
using NodeList = std::vector<std::int32_t>;

enum class SelectorKind {
  box,
  sphere,
  ellipsoid,
  plane,
  half_space,
  group,
  nodes,
  nearest,
  surface,
  free_surface,
  free,
  fixed,
  all,
  intersection,
  difference,
  complement,
  near,
  spread
};

struct Selector;
/// The union of its selectors.
using Selection = std::vector<Selector>;

/// One selector; without keys the surface without its fixed nodes, the default of active and output nodes.
struct Selector {
  SelectorKind kind = SelectorKind::free_surface;
  std::string text = "free-surface";             ///< in the physics summary: hashed, so that it must never change
  std::string description = "\"free-surface\"";  ///< in messages
  bool surface_only = false;                     ///< keep surface nodes only
  SourceLocation where = {};
  Vec3 point{};               ///< lower corner of a box, center, or point of a plane
  Vec3 other{};               ///< upper corner of a box, radii of an ellipsoid, or unit normal of a plane
  bool in_fractions = false;  ///< points are fractions of the bounding box instead of metres
  double length_m = 0;        ///< radius, tolerance, distance, or spacing of spread points; 0: by `count` or "auto"
  std::int64_t count = 0;     ///< of spread points; 0: by their spacing
  double from_fixed_m = 0;    ///< of spread points: their least distance from fixed nodes
  std::string group = {};
  NodeList nodes = {};
  std::vector<Selection> of =
      {};  ///< those that a combination is made of, `near` is near to, or points are spread over
};

/// Whether one of the selectors spreads its nodes over a part of the surface; a round tool is interpolated between
/// them.
bool spreads(const Selection& selection);
/// Spacing of the first of them that gives one [m]; 0: none does.
double spacing_m(const Selection& selection);

}  // namespace phynness
