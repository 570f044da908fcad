// Range of the coordinates of a mesh.
#pragma once

#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <sstream>
#include <string>

namespace phynness::meshes {

/// Larger coordinates [m] are refused, because sixth powers of lengths, which qualities and crossings need, would
/// overflow. The runtime limits the points of its surfaces to the same range.
inline constexpr double largest_coordinate_m = 1e25;

/// @param x  [m]; @param where  begins the message: file and cell; @param node  number in the file
inline void require_coordinates(const Eigen::RowVector3d& x, const std::string& where, std::int64_t node) {
  if (!x.allFinite())
    throw input_error(where + " has coordinates that are not finite", "node " + std::to_string(node),
                      "export the mesh again");
  if (x.cwiseAbs().maxCoeff() <= largest_coordinate_m) return;
  std::ostringstream value;
  value << "node " << node << " at (" << x[0] << ", " << x[1] << ", " << x[2] << ") m";
  throw input_error(where + " has coordinates that are too large", value.str(),
                    "export the mesh again, or check mesh.scale_to_m");
}

}  // namespace phynness::meshes
