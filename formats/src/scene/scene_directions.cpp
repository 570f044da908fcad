// The exploratory directions in the order of databases (formats/database.md).
#include <array>
#include <cmath>

#include "scene_sections.hpp"

namespace phynness {

namespace {

/// In the order of enum Directions.
constexpr const char* direction_words[] = {"3", "14", "26", "98", "hemisphere"};

using GridPoint = std::array<int, 3>;  // in {-1, 0, 1}^3

/// Axes, then edge diagonals, then corner diagonals of a cube: one, two, three non-zero components.
std::vector<GridPoint> diagonals(bool with_edges) {
  std::vector<GridPoint> points;
  for (int components = 1; components <= 3; ++components)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (x * x + y * y + z * z == components && (components != 2 || with_edges)) points.push_back({x, y, z});
  return points;
}

Vec3 unit(double x, double y, double z) {
  const double norm = std::sqrt(x * x + y * y + z * z);
  return {x / norm, y / norm, z / norm};
}

/// Whether two points are joined by an edge if each face of the cube is divided into eight triangles around its middle:
/// the non-zero components of one are components of the other.
bool adjacent(const GridPoint& a, const GridPoint& b) {
  bool a_in_b = true, b_in_a = true;
  for (std::size_t k = 0; k < 3; ++k) {
    a_in_b &= a[k] == 0 || a[k] == b[k];
    b_in_a &= b[k] == 0 || a[k] == b[k];
  }
  return a != b && (a_in_b || b_in_a);
}

}  // namespace

const char* name(Directions kind) { return direction_words[static_cast<std::size_t>(kind)]; }

Directions scene_detail::parse_directions(const SceneTable& probe) {
  const auto* node = probe.find("directions");
  const std::string given =
      node->is_integer() ? std::to_string(*node->value<std::int64_t>()) : node->value<std::string>().value_or("");
  for (std::size_t i = 0; i < std::size(direction_words); ++i)
    if (given == direction_words[i]) return static_cast<Directions>(i);
  probe.reject("directions", "is not a known set of directions", "write 14, 26, 98, 3 or \"hemisphere\"");
}

std::vector<Vec3> exploratory_directions(Directions kind) {
  if (kind == Directions::three) return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto points = diagonals(kind != Directions::fourteen);
  std::vector<Vec3> directions;
  for (const auto& p : points) directions.push_back(unit(p[0], p[1], p[2]));
  if (kind != Directions::ninety_eight) return directions;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      if (adjacent(points[i], points[j]))
        directions.push_back(unit(directions[i][0] + directions[j][0], directions[i][1] + directions[j][1],
                                  directions[i][2] + directions[j][2]));
  return directions;
}

}  // namespace phynness
