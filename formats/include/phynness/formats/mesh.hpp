// The mesh as every stage sees it: plain arrays, SI units, 0-based indices.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace phynness {

/// n x 3, row-major: one point or vector per row.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Cells = Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline Eigen::Vector3d to_eigen(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// A body made of tetrahedra (4 columns in `cells`); shells of triangles (3 columns) use the same arrays.
/// Node numbers are those of the mesh file's own node list after unreferenced nodes have been dropped.
struct Mesh {
  Points nodes;       ///< n_nodes x 3 [m], reference configuration X
  Cells cells;        ///< n_cells x 4, positively oriented
  Triangles surface;  ///< n_triangles x 3, boundary faces of `cells`, normals outward
  std::map<std::string, std::vector<std::int32_t>> groups;  ///< physical groups of the file: name -> sorted nodes

  std::int32_t n_nodes() const { return static_cast<std::int32_t>(nodes.rows()); }
  std::int32_t n_cells() const { return static_cast<std::int32_t>(cells.rows()); }
};

/// The body is its own mirror image in a plane, and so are the node sets.
struct MirrorSymmetry {
  std::array<double, 3> normal{};   ///< of the plane, unit; responses of nodes on the side it points to are solved
  std::vector<std::int32_t> image;  ///< n_nodes: where the mirror image of a node lies; on the plane itself
  bool odd = false;                 ///< linear law: the opposite displacement gives the opposite response
  bool operator==(const MirrorSymmetry&) const = default;
};

/// The nodes a scene selects on a mesh; each list sorted ascending without repeats.
struct NodeSets {
  std::vector<std::int32_t> fixed;            ///< u = 0
  std::vector<std::int32_t> active;           ///< probed one at a time
  std::vector<std::int32_t> output;           ///< their displacements are stored and modelled
  std::optional<MirrorSymmetry> mirror = {};  ///< if the scene declares a plane of symmetry
};

/// Boundary faces of tetrahedra, normals outward, in the order of the cells they belong to.
/// @pre cells has 4 columns and positive orientation.
Triangles boundary_triangles(const Cells& cells);

/// Sorted list of the nodes on `surface`.
std::vector<std::int32_t> surface_nodes(const Triangles& surface);

/// Area-weighted outward unit normals, one row per node of the mesh; zero rows for interior nodes.
Points node_normals(const Mesh& mesh);

/// 64-bit FNV-1a over the little-endian bytes of nodes then cells, as 16 lower-case hexadecimal digits.
/// Identifies the mesh in databases and models.
std::string mesh_hash(const Mesh& mesh);

/// mesh.txt: text, hexadecimal floats, exact round trip (formats/mesh.md). `fixed` travels along for display.
/// @throws Error if a group's name is empty or holds a line break
std::string write_mesh_text(const Mesh& mesh, const std::vector<std::int32_t>& fixed = {});
/// @param fixed  where to put the fixed nodes that travelled along; may be null
/// @throws Error: truncated, corrupted (checksum), another version, malformed (with the line): each its own message
Mesh read_mesh_text(const std::string& text, const std::string& source_name,
                    std::vector<std::int32_t>* fixed = nullptr);

}  // namespace phynness
