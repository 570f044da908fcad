// The mesh of all stages: plain arrays, SI units, 0-based indices.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace phynness {

/// n x 3, row-major: one point or vector per row.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Cells = Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline Eigen::Vector3d to_eigen(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// Brings a list into ascending order without repeats.
void sort_unique(std::vector<std::int32_t>& nodes);

/// A body made of tetrahedra (4 columns in `cells`), or a shell made of triangles (3 columns). Nodes have the order of
/// the mesh file without its unreferenced nodes.
struct Mesh {
  Points nodes;       ///< n_nodes x 3 [m], reference configuration X
  Cells cells;        ///< n_cells x 4, positively oriented
  Triangles surface;  ///< n_triangles x 3, boundary faces of `cells`, normals outward
  std::map<std::string, std::vector<std::int32_t>> groups;  ///< physical groups of the file: name -> sorted nodes
  std::map<std::string, std::vector<std::int32_t>> cell_groups = {};  ///< those of cells: name -> sorted cells
  /// For each cell 0 for the body's material, or i + 1 for regions[i] of the scene. Empty: the scene has no regions.
  std::vector<std::uint8_t> regions = {};

  std::int32_t n_nodes() const { return static_cast<std::int32_t>(nodes.rows()); }
  std::int32_t n_cells() const { return static_cast<std::int32_t>(cells.rows()); }
};

/// A point of the undeformed surface: a triangle's nodes and barycentric weights, >= 0 and of sum 1.
struct SurfacePoint {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  std::array<double, 3> point{};  ///< [m]
  double distance = 0;            ///< from the given point [m]
};
inline SurfacePoint at_node(std::int32_t node) { return {{node, -1, -1}, {1, 0, 0}}; }

/// What a tool moves: nodes of the surface in ascending order, with weights w.
struct TouchedNodes {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  /// Whether the tool is round: the weighted mean sum w_i u_i follows it.
  bool mean = false;
  /// Whether the tool prescribes the displacement of this node.
  bool holds(std::int32_t node) const { return !mean && std::binary_search(nodes.begin(), nodes.end(), node); }
  bool operator==(const TouchedNodes&) const = default;
};
/// Of probes that displace one node.
std::vector<TouchedNodes> single_nodes(const std::vector<std::int32_t>& nodes);

/// The nodes that a scene selects on a mesh; each list is in ascending order without repeats.
struct NodeSets {
  std::vector<std::int32_t> fixed;       ///< u = 0
  std::vector<std::int32_t> active;      ///< probed one at a time
  std::vector<std::int32_t> output;      ///< their displacements are stored and modelled
  std::vector<TouchedNodes> tools = {};  ///< what the tool at each active node moves
  /// Points of the rest of the free surface, of whose tools only the response at rest is stored.
  std::vector<std::int32_t> linear = {};
  std::vector<TouchedNodes> linear_tools = {};
};

/// Boundary faces of tetrahedra with outward normals, in the order of their cells.
/// @pre cells has 4 columns and positive orientation.
Triangles boundary_triangles(const Cells& cells);

/// Sorted list of the nodes on `surface`.
std::vector<std::int32_t> surface_nodes(const Triangles& surface);

/// Area-weighted outward unit normals, one row per node of the mesh; zero rows for interior nodes.
Points node_normals(const Points& nodes, const Triangles& surface);
inline Points node_normals(const Mesh& mesh) { return node_normals(mesh.nodes, mesh.surface); }

/// 64-bit FNV-1a over the little-endian bytes of nodes then cells, as 16 lower-case hexadecimal digits.
/// Identifies the mesh in databases and models.
std::string mesh_hash(const Mesh& mesh);

/// The first word of mesh.txt.
inline constexpr std::string_view mesh_text_magic = "phynness-mesh";

/// Text of mesh.txt with hexadecimal floats, which are read back exactly (formats/mesh.md).
/// @pre cells have 3 or 4 corners
/// @throws Error (input) if a group's name is empty or contains a line break
std::string write_mesh_text(const Mesh& mesh);
/// @throws Error (input) if the text is truncated, corrupted (checksum), of another version, or malformed (with the
/// line)
Mesh read_mesh_text(const std::string& text, const std::string& source_name);

}  // namespace phynness
