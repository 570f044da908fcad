// Rays of a symmetric body that need no solve because they are mirror images of other rays. With the normal n of the
// plane and H = 1 - 2 n n^T, the probe of node a along d and the probe of its image along H d are mirror images:
// u'(image of i) = H u(i), F' = H F, (dF/dd)' = H dF/dd H; energy, J and pivots are equal.
#pragma once

#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// For every ray of a database, the ray that is solved in its place. A ray is solved itself if the direction of its
/// mirror image is not one of the directions. Therefore every plane is possible, but only planes that map directions to
/// directions save solves.
class MirroredRays {
 public:
  /// Without a plane of symmetry in the header, every ray is solved itself.
  explicit MirroredRays(const DatabaseHeader& header);

  struct Source {
    std::int32_t active = 0, direction = 0;  ///< indices of the solved ray
    bool mirrored = false, opposite = false;
    bool is_itself() const { return !mirrored && !opposite; }
  };
  /// @param active, direction  indices as in Ray
  const Source& source(std::int32_t active, std::int32_t direction) const {
    return _sources[static_cast<std::size_t>(active) * _n_directions + static_cast<std::size_t>(direction)];
  }
  bool is_solved(std::int32_t active, std::int32_t direction) const { return source(active, direction).is_itself(); }
  /// Whether any ray of a node is solved.
  bool solves_any(std::int32_t active) const;
  std::int64_t n_solved() const { return _n_solved; }
  /// Flags of the solved rays, n_active x n_directions.
  std::vector<char> solved() const;
  std::size_t n_directions() const { return _n_directions; }

  /// The ray (active, direction), computed from its solved source. Iterations, cutbacks and seconds are zero, because
  /// no solve was needed.
  Ray image(const Ray& solved, std::int32_t active, std::int32_t direction) const;

 private:
  std::vector<Source> _sources;
  std::size_t _n_directions = 0;
  std::int64_t _n_solved = 0;
  std::array<double, 9> _reflection{};         // H, row-major
  std::vector<std::int32_t> _image_of_output;  // indices of sets.output
};

}  // namespace phynness
