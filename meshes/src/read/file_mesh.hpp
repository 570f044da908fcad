// Checked meshes of bodies and shells from a file or from gmsh, and checks that they and closed surfaces have in
// common.
#pragma once

#include <functional>
#include <phynness/formats/printable.hpp>
#include <phynness/meshes/meshes.hpp>
#include <string>
#include <vector>

#include "raw_mesh.hpp"
#include "surface/topology.hpp"

namespace phynness::meshes {

/// Larger coordinates [m] are refused, because sixth powers of lengths, which qualities and crossings need, would
/// overflow. The runtime limits the points of its surfaces to the same range.
inline constexpr double largest_coordinate_m = 1e25;

/// @param x  [m]; @param where  begins the message: file and cell; @param node  number in the file
void require_coordinates(const std::array<double, 3>& x, const std::string& where, std::int64_t node);

void scale(RawMesh& raw, double scale_to_m);
Points to_points(const std::vector<std::array<double, 3>>& nodes);

/// Drops triangles with two equal corners.
void drop_useless_triangles(RawMesh& raw);

/// Drops the nodes that no cell and no triangle uses; the others keep their order. Groups that become empty are dropped
/// with a note. @return the dropped nodes, by their position in the file
std::vector<std::int32_t> drop_unused_nodes(RawMesh& raw);
/// The same with a note about the nodes.
void drop_unreferenced_nodes(RawMesh& raw);

/// "8e-06 m^3; dropped 8e-06, 1e-09 m^3".
std::string describe_sizes(std::vector<double> sizes, std::ptrdiff_t kept, const char* unit);
/// Of the elements, in their order, keeps those of the largest component; a note says how large it and the others are.
/// @param size  of an element, with sign, in `unit`; those of a component are added
template <class Element>
void keep_largest(std::vector<Element>& elements, const Components& parts, const char* things,
                  const std::vector<double>& size, const char* unit, std::vector<std::string>& notes) {
  std::vector<double> sums(parts.component_sizes.size());
  for (std::size_t i = 0; i < elements.size(); ++i) sums[parts.component[i]] += size[i];
  for (double& sum : sums) sum = std::abs(sum);
  const auto keep = std::max_element(sums.begin(), sums.end()) - sums.begin();
  notes.push_back("repair: kept the largest of " + describe_components(parts.component_sizes, things) + ", " +
                  describe_sizes(sums, keep, unit));
  std::size_t at = 0;
  std::erase_if(elements, [&](const Element&) { return parts.component[at++] != keep; });
}

/// Nodes that are nearer to each other than a hundredth of the shortest edge at each. With `repair` they become one,
/// with a note. @return otherwise how many there are, how near, and what `repair` does; empty if there are none
std::string join_near_nodes(RawMesh& raw, bool repair);

/// Scales, drops unreferenced nodes, orients cells, and checks finiteness, volumes, overlaps, components and the
/// surface. With `repair` near nodes are merged, and only the largest of several components is kept.
/// @return mesh with surface and groups, notes and warnings; quality is set
/// @throws Error naming the defect with its count and the first cells or nodes
MeshResult checked_body(RawMesh raw, double scale_to_m, bool repair, const std::string& source);
/// The same for the middle surface of a shell, which may be open: orients triangles consistently and checks areas and
/// edges. @return cells and surface are the same triangles
MeshResult checked_shell(RawMesh raw, double scale_to_m, bool repair, const std::string& source);
/// Refuses a wall that is thicker than the surface is long or than the diameter of a bend, and warns of a wall that is
/// thicker than half the radius of a bend.
void check_wall(MeshResult& shell, double thickness_m, const std::string& source);

/// Warns of slivers. @param cell  what a cell is called
void warn_of_shape(MeshResult& result, const char* cell);
/// Warns of a body that is larger than 1 m or smaller than 1 mm, whose file may have other units.
void warn_of_size(MeshResult& result, double scale_to_m);

// sizing.cpp

struct Extent {
  double volume_m3 = 0, area_m2 = 0;
};
/// Of a built-in shape from all of its dimensions. @pre it is not the liver
Extent extent_of_shape(const MeshSpec& shape);

/// @throws Error if a mesh of this edge length would be so large that it is probably a mistake
void require_affordable(const Extent& extent, double edge_m, const std::string& place);
/// @throws Error if edges of this length would leave no node of the body
void require_short(const Extent& extent, double edge_m, bool is_file, const std::string& place);

/// Where meshing fails at an edge length, this part of it is tried, which gives a surface of different triangles.
inline constexpr double slightly_finer = 0.98;

/// Makes several meshes (secant method on the logarithms of size and number) and returns the mesh whose number of nodes
/// is nearest to the target; a note states the result. It is deterministic if `mesh_at` is.
/// @throws Error as `mesh_at`, if no size worked
MeshResult meet_node_target(int target, const Extent& extent, const std::string& place,
                            const std::function<MeshResult(double edge_m)>& mesh_at);

}  // namespace phynness::meshes
