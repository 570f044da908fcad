// Rays of a symmetric body that need no solve: mirror images of others. With n the normal of the plane and
// H = 1 - 2 n n^T, the probe of node a along d and that of its image along H d are one another's image:
// u(image of i) = H u(i), F = H F, dF/dd = H dF/dd H; energy, J and pivots are the same.
#pragma once

#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// For every ray of a database, the ray that is solved in its place. A ray whose mirror image runs along none
/// of the directions is solved itself, so that any plane is right and one that suits the directions saves
/// most.
class MirroredRays {
 public:
  /// @param header  without a plane of symmetry every ray is solved itself
  explicit MirroredRays(const DatabaseHeader& header);

  struct Source {
    std::int32_t active = 0, direction = 0;  ///< of the ray that is solved
    bool mirrored = false, opposite = false;
    bool is_itself() const { return !mirrored && !opposite; }
  };
  /// @param active, direction  indices as in Ray
  const Source& source(std::int32_t active, std::int32_t direction) const {
    return _sources[static_cast<std::size_t>(active) * _n_directions + static_cast<std::size_t>(direction)];
  }
  bool is_solved(std::int32_t active, std::int32_t direction) const { return source(active, direction).is_itself(); }
  /// Whether a node has a ray that is solved.
  bool solves_any(std::int32_t active) const;
  std::int64_t n_solved() const { return _n_solved; }
  /// n_active x n_directions flags
  std::vector<char> solved() const;
  std::size_t n_directions() const { return _n_directions; }

  /// The ray (active, direction) from the solve of its source. Iterations, cutbacks and seconds are zero: no
  /// work was done.
  Ray image(const Ray& solved, std::int32_t active, std::int32_t direction) const;

 private:
  std::vector<Source> _sources;
  std::size_t _n_directions = 0;
  std::int64_t _n_solved = 0;
  std::array<double, 9> _reflection{};         // H, row-major
  std::vector<std::int32_t> _image_of_output;  // index into sets.output
};

}  // namespace phynness
