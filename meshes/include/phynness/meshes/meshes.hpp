// Origin of meshes: built-in shapes, files of the user, checks of quality and topology, selections of nodes.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <phynness/formats/described.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

struct QualityReport {
  std::int32_t n_nodes = 0, n_cells = 0, n_surface_nodes = 0, n_surface_triangles = 0;
  double volume_m3 = 0, area_m2 = 0;  ///< of the cells of a solid, or of the triangles of a shell
  Vec3 min_m{}, max_m{};              ///< bounding box
  double min_quality = 0;             ///< radius ratio 3 r_in / r_circ (triangles: 2 r_in / r_circ): 1 regular, 0 flat
  std::int32_t worst_cell = -1;
  std::int32_t n_slivers = 0;  ///< cells with quality below `sliver_quality`
  double mean_edge_m = 0, min_edge_m = 0, max_edge_m = 0;
};
inline constexpr double sliver_quality = 0.1;

/// A mesh that is ready for the solver, with a description of changes and warnings.
struct MeshResult {
  Mesh mesh;
  QualityReport quality;
  std::vector<std::string> notes;     ///< repairs and facts: "dropped 3 unreferenced nodes: 17, 18, 44"
  std::vector<std::string> warnings;  ///< doubts about the mesh: "12 slivers, worst quality 0.017 in cell 871"
  bool made_here = false;             ///< the cells are not those of a file
};

/// The mesh of a scene: a built-in shape (gmsh) or a file, scaled to metres and checked. Cells are positively oriented,
/// every node is referenced, the body is one connected component and its surface is a closed manifold. Any defect
/// results in an error that names it, or in a repair that `notes` lists. With a thickness the mesh is the middle
/// surface of a shell: cells are triangles, and the surface may be open.
/// @param in_file_units  the scene has no scale: nothing is said of metres
/// @throws Error
MeshResult make_mesh(const Scene& scene, bool in_file_units = false);

/// True if a file has only triangles and some edges belong to one triangle. Such a surface does not enclose a body, but
/// may be that of a shell.
/// @throws Error as make_mesh for a file that cannot be read
bool holds_open_surface(const std::filesystem::path& file);

/// The triangles of a file as the middle surface of a shell, in the units of the file, without checks that need a
/// thickness.
/// @throws Error
MeshResult make_shell(const std::filesystem::path& file);

/// The checks of quality for any mesh.
QualityReport measure_quality(const Mesh& mesh);

/// How many cells lie across the body below nodes of its surface: the way along the inner normal through the body, over
/// the mean edge.
struct CellsAcross {
  double least = 0, median = 0;  ///< 0: no way was found
  std::int32_t thinnest = -1;    ///< the node of the least number
  PHYNNESS_FIGURES(least, median, thinnest)
};
/// @pre the cells are tetrahedra
CellsAcross cells_across(const Mesh& mesh, const std::vector<std::int32_t>& nodes);

/// A cell, its quality (QualityReport::min_quality), and where it is.
struct CellQuality {
  std::int32_t cell = -1;
  double quality = 0;
  Vec3 center_m{};
  int corners = 4, on_surface = 0, fixed = 0;  ///< how many there are, and how many of them are there
  PHYNNESS_FIGURES(cell, quality, center_m, on_surface, fixed)
  /// "cell 871: quality 0.017, at (12.3, 40.1, 8) mm, 3 of its 4 nodes on the surface, 1 fixed" (unless none is).
  /// @param per_m  of the unit of lengths
  std::string str(double per_m = 1000, const char* unit = " mm") const;
};
/// @param fixed  nodes, ascending
CellQuality cell_quality(const Mesh& mesh, std::int32_t cell, const NodeList& fixed);
/// The cells of lowest quality, the worst first.
std::vector<CellQuality> worst_cells(const Mesh& mesh, const NodeList& fixed, std::size_t count = 3);

/// Edges of the cells, the smaller node first, ascending.
std::vector<std::array<std::int32_t, 2>> mesh_edges(const Mesh& mesh);

/// The same body with half the edge length: each tetrahedron is divided into eight, each triangle into four. The nodes
/// keep their numbers, and the midpoints of mesh_edges() follow in this order. Flat parts of the surface remain flat.
Mesh refined(const Mesh& mesh);
/// A set of nodes (ascending) with the midpoints of edges between two of them.
std::vector<std::int32_t> refined(const std::vector<std::int32_t>& nodes,
                                  const std::vector<std::array<std::int32_t, 2>>& edges, std::int32_t n_nodes);

/// Writes gmsh format 4.1 (ASCII): nodes in their order, tetrahedra if there are any, triangles, physical groups. If
/// `sets` is given, its lists become the physical point groups phynness_fixed, phynness_active, phynness_output. Cells
/// of regions become volumes of their own. make_mesh reads the file with the same node numbers, cells and hash.
void write_msh(const Mesh& mesh, const NodeSets* sets, const std::filesystem::path& file);

/// True if the fixed nodes prevent every rigid motion: at least three nodes that are not on one line, or an edge of a
/// shell, which is clamped there. A singular factorization does not detect this reliably, because rounding turns its
/// zero pivots into small numbers.
bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed);

/// The fixed nodes that the scene has on another mesh of its body.
/// @throws Error (input) also if it selects nodes of one mesh, as by their numbers
NodeList resolve_fixed(const Scene& scene, const Mesh& other);

/// The region of each cell, as Mesh::regions: those of the mesh if it has them, otherwise by the selections of the
/// scene, which places select by the centroids of cells.
/// @throws Error (input, with file:line) if a region has no cell or all of them, if regions of the same order overlap,
///   or if the mesh has no such group of cells
std::vector<std::uint8_t> cell_regions(const Scene& scene, const Mesh& mesh);

/// The physical group of cells that write_msh() writes of a region. @param number  from 1, as in Mesh::regions
std::string region_group(std::size_t number);
inline constexpr const char* region_group_prefix = "phynness_region_";

/// Sets the regions of a mesh that was read from a file of write_msh(): its groups of cells.
/// @throws Error (input) if it has no group for a region, or if fewer than half of the cells of a region that the scene
///   selects by place are where the scene has it
void take_written_regions(const Scene& scene, Mesh& mesh, const std::string& source);

/// A part of a mesh with one material. The first is the rest of the body.
struct RegionFigures {
  std::string name;
  std::int32_t cells = 0;
  double volume_m3 = 0;
  double off = 0;  ///< volume of wrongly assigned parts of cells over that of the region, sampled at 64 points a cell
  double shear_modulus_Pa = 0, bulk_modulus_Pa = 0, bulk_to_shear = 0;
  PHYNNESS_FIGURES(name, cells, volume_m3, off, shear_modulus_Pa, bulk_modulus_Pa, bulk_to_shear)
  /// "region nodule: 124 cells, 0.52 mL (1.3 % of that in cells of another part), shear modulus 1.2e+04 Pa, K/mu 20"
  std::string str() const;
};
/// Empty if the scene has no regions. @throws Error as cell_regions()
std::vector<RegionFigures> region_figures(const Scene& scene, const Mesh& mesh);

/// Resolves the selections of the scene on a mesh.
/// @throws Error (with file:line) if a selection is empty, an active node is also fixed, no node is fixed, a group is
///   unknown (the message lists the existing ones), or a node number is out of range
NodeSets resolve_selections(const Scene& scene, const Mesh& mesh);
/// The same with output `sets`, which after an error contains the selections that were made before it.
/// @param probed  active nodes of a database of the mesh: spread points keep those that are in their part of the
/// surface
void resolve_selections(const Scene& scene, const Mesh& mesh, NodeSets& sets, const NodeList& probed = {});
/// Sets the points of the free surface beside the active nodes, so that both together have one spacing, and their
/// tools.
void select_elsewhere(const Scene& scene, const Mesh& mesh, NodeSets& sets);

}  // namespace phynness
