// The contents of a mesh file before checks and scaling.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <phynness/formats/mesh.hpp>
#include <string>
#include <utility>
#include <vector>

namespace phynness::meshes {

using Tetrahedron = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;

/// Nodes in the order of the file and in its units; cells refer to 0-based positions in this list.
struct RawMesh {
  std::vector<std::array<double, 3>> nodes;
  std::vector<Tetrahedron> tetrahedra;
  std::vector<Triangle> triangles;
  std::map<std::string, std::vector<std::int32_t>> groups;  ///< physical groups: name -> sorted nodes
  std::vector<std::string> notes;
};

/// Collects physical groups while elements are read, and names them after the whole file was read.
class GroupBuilder {
 public:
  void name(int dimension, std::int64_t tag, std::string text) { _names[{dimension, tag}] = std::move(text); }
  void add(int dimension, std::int64_t tag, const std::vector<std::int32_t>& nodes);
  /// Groups by name, or by tag number if the file gives no name. A tag without a name that several dimensions use
  /// becomes one group "7" for all of them and one group for each, "line 7", "surface 7", with a note.
  void finish(RawMesh& raw) const;

 private:
  std::map<std::pair<int, std::int64_t>, std::string> _names;
  std::map<std::pair<int, std::int64_t>, std::vector<std::int32_t>> _nodes;
};

/// Readers. Each throws an Error with the file, the place and the defect. `bytes` is the whole file.
RawMesh read_msh(const std::string& bytes, const std::string& source);
RawMesh read_vtk(const std::string& bytes, const std::string& source);
RawMesh read_stl(const std::string& bytes, const std::string& source);
RawMesh read_obj(const std::string& bytes, const std::string& source);
RawMesh read_vtu(const std::string& bytes, const std::string& source);
RawMesh read_vtp(const std::string& bytes, const std::string& source);
RawMesh read_ply(const std::string& bytes, const std::string& source);
RawMesh read_off(const std::string& bytes, const std::string& source);
RawMesh read_inp(const std::string& bytes, const std::string& source);

/// Selects the reader by the extension of the file name.
RawMesh read_mesh_file(const std::filesystem::path& file);

}  // namespace phynness::meshes
