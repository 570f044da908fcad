// Scenes and files that the mesh tests make up.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <stdexcept>
#include <string>

#include "../messages.hpp"

#define SKIP_WITHOUT_GMSH() \
  if (!PHYNNESS_TEST_GMSH) GTEST_SKIP() << "built without gmsh"

namespace phynness::test {

/// A file that goes away with the object.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& bytes, const std::string& extension) {
    static int counter = 0;
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "-" + info->name();
    std::replace(name.begin(), name.end(), '/', '-');  // of tests with parameters
    path = std::filesystem::temp_directory_path() / ("phynness-" + name + "-" + std::to_string(counter++) + extension);
    std::ofstream file(path, std::ios::binary);
    file << bytes;
    if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  std::filesystem::path path;
};

inline MeshResult import_file(const std::filesystem::path& file, double scale_to_m = 1, bool repair = false) {
  Scene scene;
  scene.mesh.file = file;
  scene.mesh.scale_to_m = scale_to_m;
  scene.mesh.repair = repair;
  return make_mesh(scene);
}

inline MeshResult import_bytes(const std::string& bytes, const std::string& extension, bool repair = false) {
  const TemporaryFile file(bytes, extension);
  return import_file(file.path, 1, repair);
}

/// The message with which such a file is refused; empty if it is not.
inline std::string import_error(const std::string& bytes, const std::string& extension) {
  return error_of([&] { import_bytes(bytes, extension); });
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

inline MeshResult shape(Shape kind, int target_nodes = 0) {
  Scene scene;
  scene.mesh.shape = kind;
  if (target_nodes > 0) scene.mesh.target_nodes = target_nodes;
  return make_mesh(scene);
}

/// A 3 x 3 x 3 grid of nodes with spacing 1, numbered along x first, of 48 cells.
inline Mesh grid() {
  Mesh mesh;
  mesh.nodes.resize(27, 3);
  for (int i = 0; i < 27; ++i) {
    const int x = i % 3, y = i / 3 % 3, z = i / 9;
    mesh.nodes.row(i) << x, y, z;
  }
  const int paths[6][2] = {{1, 3}, {1, 9}, {3, 1}, {3, 9}, {9, 1}, {9, 3}};  // Kuhn's six tetrahedra of a cube
  std::vector<std::array<int, 4>> cells;
  for (int c = 0; c < 8; ++c)
    for (const auto& [p, q] : paths) {
      const int a = c % 2 + 3 * (c / 2 % 2) + 9 * (c / 4);
      std::array<int, 4> cell{a, a + p, a + p + q, a + 13};
      const Eigen::RowVector3d u = mesh.nodes.row(cell[1]) - mesh.nodes.row(a),
                               v = mesh.nodes.row(cell[2]) - mesh.nodes.row(a),
                               w = mesh.nodes.row(cell[3]) - mesh.nodes.row(a);
      Eigen::Matrix3d m;
      m << u, v, w;
      if (m.determinant() < 0) std::swap(cell[2], cell[3]);
      cells.push_back(cell);
    }
  mesh.cells.resize(static_cast<Eigen::Index>(cells.size()), 4);
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int k = 0; k < 4; ++k) mesh.cells(static_cast<Eigen::Index>(c), k) = cells[c][k];
  mesh.surface = boundary_triangles(mesh.cells);
  mesh.groups["corners"] = {0, 2, 6, 8};
  return mesh;
}

/// Two tetrahedra on a common face, in .msh 2.2; `cells` are the lines of the elements.
inline std::string msh_2(const std::string& cells, int n_cells,
                         const std::string& nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n", int n_nodes = 5) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(n_nodes) + "\n" + nodes +
         "$EndNodes\n$Elements\n" + std::to_string(n_cells) + "\n" + cells + "$EndElements\n";
}
inline const char* two_cells = "1 4 2 0 1 1 2 3 4\n2 4 2 0 1 2 5 3 4\n";

}  // namespace phynness::test
