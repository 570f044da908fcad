// The exploratory directions, in the order that databases number them (formats/database.md).
#include <cmath>
#include <phynness/formats/scene.hpp>

namespace phynness {

std::vector<Vec3> exploratory_directions(Directions kind) {
  if (kind == Directions::three) return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> directions;
  // Axes, then edge diagonals, then corner diagonals: one, two, three non-zero components.
  for (int components = 1; components <= 3; ++components)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const int squared = x * x + y * y + z * z;
          if (squared != components) continue;
          const double norm = std::sqrt(static_cast<double>(squared));
          directions.push_back({x / norm, y / norm, z / norm});
        }
  return directions;
}

}  // namespace phynness
