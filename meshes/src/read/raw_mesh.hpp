// The contents of a mesh file before checks and scaling.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <phynness/formats/mesh.hpp>
#include <string>
#include <vector>

namespace phynness::meshes {

inline constexpr int gmsh_triangle = 2, gmsh_tetrahedron = 4;  ///< element types of gmsh

using Tetrahedron = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;

/// Nodes in the order of the file and in its units; cells refer to 0-based positions in this list.
struct RawMesh {
  std::vector<std::array<double, 3>> nodes;
  std::vector<Tetrahedron> tetrahedra;
  std::vector<Triangle> triangles;
  std::vector<std::vector<std::int32_t>> polyhedra;  ///< hexahedra, wedges and pyramids, until finish() splits them
  std::map<std::string, std::vector<std::int32_t>> groups;  ///< physical groups: name -> sorted nodes
  /// Physical groups of cells: name -> corners of each cell, by which it is found again when cells are split or
  /// dropped.
  std::map<std::string, std::vector<std::vector<std::int32_t>>> cell_groups;
  std::vector<std::string> notes;
  std::vector<std::int32_t> file_number;  ///< position of each node in the file; empty: no node was dropped

  /// Adds a solid cell of 4, 5, 6 or 8 corners, numbered as by Abaqus and gmsh. @return false for other numbers
  bool add_cell(const std::vector<std::int32_t>& corners);

  /// Adds the triangles of a polygon of at least three corners.
  void add_polygon(const std::vector<std::int32_t>& corners) {
    for (std::size_t k = 2; k < corners.size(); ++k) triangles.push_back({corners[0], corners[k - 1], corners[k]});
  }

  /// Calls visit for each node of each cell and triangle.
  template <class Visit>
  void for_each_corner(const Visit& visit) {
    for (auto& cell : tetrahedra) std::for_each(cell.begin(), cell.end(), visit);
    for (auto& triangle : triangles) std::for_each(triangle.begin(), triangle.end(), visit);
    for (auto& cell : polyhedra) std::for_each(cell.begin(), cell.end(), visit);
  }

  /// Calls visit for each node of each group; the lists of nodes are sorted again.
  template <class Visit>
  void renumber_groups(const Visit& visit) {
    for (auto& [name, group] : groups) {
      std::for_each(group.begin(), group.end(), visit);
      sort_unique(group);
    }
    for (auto& [name, cells] : cell_groups)
      for (auto& cell : cells) std::for_each(cell.begin(), cell.end(), visit);
  }

  /// What all formats have in common: nodes at the same place become one, other cells are split into tetrahedra, and
  /// repeated cells are dropped, each with a note. @param welds  the format repeats nodes: no note about these
  void finish(bool welds);
};

/// Readers. Each throws an Error with the file, the place and the defect. `bytes` is the whole file.
RawMesh read_msh(const std::string& bytes, const std::string& source);
RawMesh read_vtk(const std::string& bytes, const std::string& source);
RawMesh read_stl(const std::string& bytes, const std::string& source);
RawMesh read_obj(const std::string& bytes, const std::string& source);
RawMesh read_vtu(const std::string& bytes, const std::string& source);
RawMesh read_ply(const std::string& bytes, const std::string& source);
RawMesh read_off(const std::string& bytes, const std::string& source);
RawMesh read_inp(const std::string& bytes, const std::string& source);

/// Selects the reader by the extension of the file name.
RawMesh read_mesh_file(const std::filesystem::path& file);

}  // namespace phynness::meshes
