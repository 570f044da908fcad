// The point of a triangulated surface that is closest to a given point.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "surface.hpp"

namespace phynness::meshes {

/// Tree of bounding boxes over the triangles of a surface, which must outlive it.
class ClosestPoint {
 public:
  explicit ClosestPoint(const Surface& surface);
  Eigen::RowVector3d operator()(const Eigen::RowVector3d& x) const;

 private:
  struct Box {
    Eigen::RowVector3d low, high;
    std::int32_t first = 0, last = 0;  // range of _order; it has children only if left >= 0
    std::int32_t left = -1, right = -1;
  };
  std::int32_t build(std::int32_t first, std::int32_t last, const Points& centroids);

  const Surface& _surface;
  std::vector<std::int32_t> _order;
  std::vector<Box> _boxes;
};

}  // namespace phynness::meshes
