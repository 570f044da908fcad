// Conversion of VTK cells, for legacy and XML files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raw_mesh.hpp"

namespace phynness::meshes {

inline constexpr int vtk_vertex = 1, vtk_poly_vertex = 2, vtk_poly_line = 4, vtk_triangle = 5, vtk_strip = 6,
                     vtk_polygon = 7, vtk_pixel = 8, vtk_quad = 9, vtk_tetrahedron = 10, vtk_voxel = 11,
                     vtk_hexahedron = 12, vtk_wedge = 13, vtk_pyramid = 14;

/// Names of arrays of cells whose integers are groups: of `phynness show`, of users, and as meshio and gmsh write them.
/// The first of them that a file holds is used.
inline constexpr const char* region_arrays[] = {"region",    "material",  "gmsh:physical",
                                                "medit:ref", "cell_tags", "CellEntityIds"};
/// Says that an array is not used.
inline std::string not_groups(const std::string& name, const std::string& type) {
  return "the array '" + name + "' of the cells holds " + type +
         " and makes no groups: save it as one integer for each cell";
}

/// Adds cells to `raw`, polygons and strips as triangles; points and lines are skipped.
/// @param ends    position in `points` behind the last point of each cell
/// @param points  of all cells, below `n_points`; `first` is added to each
/// @param types   of each cell
/// @param regions of each cell: a solid cell is in the group that has this number as its name; empty: no groups
/// @param fail    throws what(message, value, remedy) for a cell that cannot be used
template <class Fail>
void add_vtk_cells(const std::vector<std::int64_t>& ends, const std::vector<std::int64_t>& points, std::size_t n_points,
                   std::int32_t first, const std::vector<std::int64_t>& types, const std::vector<std::int64_t>& regions,
                   RawMesh& raw, const Fail& fail) {
  std::vector<std::int32_t> cell;
  std::size_t at = 0;
  for (std::size_t c = 0; c < ends.size(); ++c) {
    if (ends[c] < static_cast<std::int64_t>(at) || static_cast<std::uint64_t>(ends[c]) > points.size())
      fail("the cell offsets do not ascend", std::to_string(ends[c]));
    cell.clear();
    for (; at < static_cast<std::size_t>(ends[c]); ++at) {
      if (points[at] < 0 || static_cast<std::size_t>(points[at]) >= n_points)
        fail("a cell uses a point that is not in the file", std::to_string(points[at]));
      cell.push_back(first + static_cast<std::int32_t>(points[at]));
    }
    const std::int64_t type = types[c];
    const auto corners = static_cast<std::int64_t>(cell.size());
    if ((type == vtk_voxel && corners == 8) || (type == vtk_pixel && corners == 4))  // in the order of coordinates
      for (std::size_t k = 2; k < cell.size(); k += 4) std::swap(cell[k], cell[k + 1]);
    if (type == vtk_wedge && corners == 6) std::swap(cell[1], cell[2]), std::swap(cell[4], cell[5]);
    const bool polygon = type == vtk_triangle || type == vtk_quad || type == vtk_polygon || type == vtk_pixel;
    const bool solid = corners == (type == vtk_tetrahedron                       ? 4
                                   : type == vtk_voxel || type == vtk_hexahedron ? 8
                                   : type == vtk_wedge                           ? 6
                                   : type == vtk_pyramid                         ? 5
                                                                                 : -1);
    if (solid && !regions.empty()) raw.cell_groups[std::to_string(regions[c])].push_back(cell);
    if (solid)
      raw.add_cell(cell);
    else if (polygon && corners >= 3)
      raw.add_polygon(cell);
    else if (type == vtk_strip && corners >= 3)
      for (std::size_t k = 2; k < cell.size(); ++k)
        raw.triangles.push_back({cell[k - 2 + k % 2], cell[k - 1 - k % 2], cell[k]});
    else if (type < vtk_vertex || type > vtk_poly_line || (type == vtk_vertex && corners != 1))
      fail("cell " + std::to_string(c) + " is of a type that is not supported, or has too few points",
           "VTK cell type " + std::to_string(type) + " with " + std::to_string(corners) + " points",
           "mesh the body with 4-node tetrahedra (type 10) and export it again");
  }
}

}  // namespace phynness::meshes
