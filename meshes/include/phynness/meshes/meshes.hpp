// Where shapes come from: built-in shapes, files of the user, quality and topology checks, node selections.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

struct QualityReport {
  std::int32_t n_nodes = 0, n_cells = 0, n_surface_nodes = 0, n_surface_triangles = 0;
  double volume_m3 = 0, area_m2 = 0;  ///< of a solid's cells, of a shell's triangles
  Vec3 min_m{}, max_m{};              ///< bounding box
  double min_quality = 0;             ///< radius ratio 3 r_in / r_circ (triangles: 2 r_in / r_circ): 1 regular, 0 flat
  std::int32_t worst_cell = -1;
  std::int32_t n_slivers = 0;  ///< cells with quality below `sliver_quality`
  double mean_edge_m = 0, min_edge_m = 0, max_edge_m = 0;
};
inline constexpr double sliver_quality = 0.1;

/// A mesh ready to be solved on, and what was done to it on the way.
struct MeshResult {
  Mesh mesh;
  QualityReport quality;
  std::vector<std::string> notes;     ///< repairs and facts: "dropped 3 unreferenced nodes: 17, 18, 44"
  std::vector<std::string> warnings;  ///< solvable, but look: "12 slivers, worst quality 0.017 in cell 871"
};

/// The mesh a scene asks for: built-in shape (gmsh) or file, scaled to metres, checked.
/// Cells are positively oriented, every node is referenced, the body is one connected component and its surface a
/// closed manifold; anything else is an error that names the defect, or a repair that is named in `notes`.
/// With a thickness the mesh is the middle surface of a shell: cells are triangles, and the surface may be open.
/// @throws Error
MeshResult make_mesh(const Scene& scene);

/// True if a file holds triangles alone, and edges that one triangle has: not the surface of a body, perhaps a shell's.
/// @throws Error as make_mesh for a file that cannot be read
bool holds_open_surface(const std::filesystem::path& file);

/// A file's triangles as the middle surface of a shell, in the file's units, without a thickness to check it against.
/// @throws Error
MeshResult make_shell(const std::filesystem::path& file);

/// The checks alone, for a mesh from elsewhere.
QualityReport measure_quality(const Mesh& mesh);

/// Edges of the cells, the smaller node first, ascending.
std::vector<std::array<std::int32_t, 2>> mesh_edges(const Mesh& mesh);

/// The same body with half the edge length: each tetrahedron is cut into eight, each triangle into four. The nodes keep
/// their numbers, and those in the middles of mesh_edges() follow in that order. Flat triangles of a surface stay flat.
Mesh refined(const Mesh& mesh);
/// Of a set of nodes (ascending): these, and the middles of edges between two of them.
std::vector<std::int32_t> refined(const std::vector<std::int32_t>& nodes,
                                  const std::vector<std::array<std::int32_t, 2>>& edges, std::int32_t n_nodes);

/// Writes gmsh format 4.1 (ASCII): nodes in their order, tetrahedra if it has any, triangles, physical groups; when
/// `sets` is given its lists become physical point groups phynness_fixed, phynness_active, phynness_output. Written by
/// our own code or gmsh, but reading it back through make_mesh gives the same node numbers, cells and hash.
void write_msh(const Mesh& mesh, const NodeSets* sets, const std::filesystem::path& file);

/// Resolves the scene's selections on a mesh, and pairs the nodes where the scene declares a plane of symmetry.
/// @throws Error (with file:line) on an empty selection, an active node that is also fixed, no fixed node, an unknown
///         group (lists those there are), a node number out of range, a mesh or a set that is declared symmetric
///         and is not
NodeSets resolve_selections(const Scene& scene, const Mesh& mesh);

}  // namespace phynness
