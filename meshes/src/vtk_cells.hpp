// What VTK's cell types become, in legacy and in XML files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raw_mesh.hpp"

namespace phynness::meshes {

inline constexpr int vtk_vertex = 1, vtk_poly_line = 4, vtk_polygon = 7, vtk_triangle = 5, vtk_quad = 9,
                     vtk_tetrahedron = 10;

/// Adds a cell to `raw`: tetrahedra as they are, polygons as triangles; points and lines are skipped.
/// @param fail  throws what(message, value, remedy) for a cell that is of no use
template <class Fail>
void add_vtk_cell(const std::vector<std::int32_t>& cell, std::size_t number, std::int64_t type, RawMesh& raw,
                  const Fail& fail) {
  const auto refuse = [&](const std::string& what) {
    fail("cell " + std::to_string(number) + what,
         "VTK cell type " + std::to_string(type) + " with " + std::to_string(cell.size()) + " points",
         "mesh the body with 4-node tetrahedra (type 10) and export it again");
  };
  if (type == vtk_tetrahedron) {
    if (cell.size() != 4) refuse(" is a tetrahedron without four points");
    raw.tetrahedra.push_back({cell[0], cell[1], cell[2], cell[3]});
  } else if (type == vtk_triangle || type == vtk_quad || type == vtk_polygon) {
    if (cell.size() < 3) refuse(" is a polygon with fewer than three points");
    for (std::size_t k = 2; k < cell.size(); ++k) raw.triangles.push_back({cell[0], cell[k - 1], cell[k]});
  } else if (type < vtk_vertex || type > vtk_poly_line) {
    refuse(" is of a type that is not supported");
  }
}

}  // namespace phynness::meshes
