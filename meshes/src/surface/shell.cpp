#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <phynness/formats/error.hpp>

#include "geometry.hpp"
#include "read/file_mesh.hpp"
#include "surface.hpp"

namespace phynness::meshes {
namespace {

// A director is the mean normal of the two triangles at an edge. Beyond this angle it represents neither of them.
constexpr double sharpest_fold_deg = 120, sharp_fold_deg = 60;
constexpr double flat_triangle = 1e-6;  // twice the area over the square of the longest edge
// Area of the inner face over that of the middle surface, 1 - t / (2 R) for a bend of radius R. Below 0.75, t > R / 2,
// the theory of shells has errors of some per cent. The inner face of a wall of thickness 2 R intersects itself.
constexpr double thick_layer = 0.75, thickest_layer = 0.05;
// As a fraction of the length of the surface. The ratio of bending stiffness to membrane stiffness is the square of
// this.
constexpr double thinnest_wall = 1e-12;

void require_sound_edges(SurfaceTopology topology, const std::string& source) {
  topology.open_edges.clear();
  topology.inconsistent_edges.clear();
  if (const std::string defects = describe_defects(topology, true); !defects.empty())
    throw input_error(source + ": the triangles do not form the surface of a shell", defects,
                      topology.component_sizes.size() > 1
                          ? "keep one piece, or set mesh.repair = true to keep the largest"
                          : "change the mesh: at most two triangles may share an edge, and the triangles of a node "
                            "must form one fan");
}

void require_areas(const Mesh& mesh, const std::string& source) {
  std::vector<std::int32_t> flat;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const auto [a, b, c] = corners_of(mesh.nodes, mesh.cells, t);
    const Eigen::RowVector3d u = b - a, v = c - a;
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
    if (!(u.cross(v).norm() > flat_triangle * longest)) flat.push_back(static_cast<std::int32_t>(t));
  }
  if (!flat.empty())
    throw input_error(source + ": triangles have no area",
                      counted(flat.size(), "triangle", "triangles") + ": " + first_few(flat), "mesh the surface again");
}

Edge cell_edge(const Mesh& mesh, Eigen::Index t, int i) {
  return edge_of(mesh.cells(t, i), mesh.cells(t, (i + 1) % 3));
}

/// Unit normals of the triangles at each edge.
std::map<Edge, std::vector<Eigen::RowVector3d>> normals_at_edges(const Mesh& mesh) {
  std::map<Edge, std::vector<Eigen::RowVector3d>> normals;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const auto [a, b, c] = corners_of(mesh.nodes, mesh.cells, t);
    for (int i = 0; i < 3; ++i) normals[cell_edge(mesh, t, i)].push_back((b - a).cross(c - a).normalized());
  }
  return normals;
}

void look_at_folds(const Mesh& mesh, const std::string& source, std::vector<std::string>& warnings) {
  const auto cosine = [](double degrees) { return std::cos(degrees * 3.14159265358979 / 180); };
  std::size_t sharp = 0;
  for (const auto& [edge, pair] : normals_at_edges(mesh)) {
    if (pair.size() < 2) continue;
    const double cos_angle = pair[0].dot(pair[1]);
    if (cos_angle < cosine(sharpest_fold_deg))
      throw input_error(source + ": the shell's middle surface is folded back on itself",
                        "at the edge between nodes " + std::to_string(edge[0]) + " and " + std::to_string(edge[1]),
                        "round the fold, or mesh it finer");
    sharp += cos_angle < cosine(sharp_fold_deg);
  }
  if (sharp > 0)
    warnings.push_back("the surface turns by more than 60 degrees at " + counted(sharp, "edge", "edges") +
                       ": shell theory needs a smooth surface; mesh it finer there, or model the corner as a solid");
}

}  // namespace

MeshResult checked_shell(RawMesh raw, double scale_to_m, bool repair, const std::string& source) {
  MeshResult result;
  raw.tetrahedra.clear();
  drop_useless_triangles(raw);
  drop_unreferenced_nodes(raw);
  scale(raw, scale_to_m);
  for (std::size_t i = 0; i < raw.nodes.size(); ++i)
    require_coordinates(raw.nodes[i], source + ": a node", raw.file_number[i]);
  if (const std::string near = join_near_nodes(raw, repair); !near.empty())
    result.warnings.push_back("the surface has a slit there, unless the nodes should be merged: " + near);
  if (raw.triangles.empty())
    throw input_error(source + ": holds no triangle with three different corners", "",
                      "give the middle surface of a shell");
  auto topology = surface_topology(to_matrix(raw.triangles));
  if (repair) keep_largest_surface(raw, topology);
  drop_unreferenced_nodes(raw);
  require_sound_edges(topology, source);

  Mesh& mesh = result.mesh;
  mesh.nodes = to_points(raw.nodes);
  mesh.surface = to_matrix(raw.triangles);
  result.notes = std::move(raw.notes);
  if (!orient(mesh.surface, topology, result.notes))
    throw input_error(source + ": the surface is not orientable", "",
                      "cut the surface so that it has a front and a back");
  if (topology.open_edges.empty() && enclosed_volume(mesh.nodes, mesh.surface) < 0)
    mesh.surface.col(1).swap(mesh.surface.col(2));
  mesh.cells = mesh.surface;
  mesh.groups = std::move(raw.groups);
  require_areas(mesh, source);
  look_at_folds(mesh, source, result.warnings);
  result.quality = measure_quality(mesh);
  warn_of_shape(result, "triangle");
  return result;
}

void check_wall(MeshResult& result, double thickness_m, const std::string& source) {
  const Mesh& mesh = result.mesh;
  const double longest = extent_of(mesh.nodes).maxCoeff();
  if (!(thickness_m < longest))
    throw input_error(
        source + ": the shell is thicker than it is long",
        "thickness_m = " + length_text(thickness_m) + ", the middle surface is " + length_text(longest) + " long",
        "check the units, lengths are in metres; simulate a thick wall as a solid, without thickness_m");
  if (thickness_m < thinnest_wall * longest)
    throw input_error(
        source + ": the wall is too thin for double precision",
        "thickness_m = " + length_text(thickness_m) + ", the middle surface is " + length_text(longest) + " long",
        "check the units, lengths are in metres; make the wall at least " + length_text(thinnest_wall * longest) +
            " thick");
  std::map<Edge, Eigen::RowVector3d> directors;
  for (const auto& [edge, normals] : normals_at_edges(mesh))
    directors[edge] = (normals.size() > 1 ? Eigen::RowVector3d(normals[0] + normals[1]) : normals[0]).normalized();
  double thinnest = 1;
  Eigen::Index worst = 0;
  for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
    const auto [a, b, c] = corners_of(mesh.nodes, mesh.cells, t);
    const Eigen::RowVector3d u = b - a, v = c - a;
    std::array<Eigen::RowVector3d, 3> D;
    for (int i = 0; i < 3; ++i) D[static_cast<std::size_t>(i)] = directors.at(cell_edge(mesh, t, i));
    // Linear in the triangle, given at the midpoints of its edges 0-1, 1-2, 2-0.
    const Eigen::RowVector3d along_u = 2 * (D[1] - D[2]), along_v = 2 * (D[1] - D[0]);
    const Eigen::RowVector3d middle = (D[0] + D[1] + D[2]) / 3;
    for (const double zeta : {thickness_m / 2, -thickness_m / 2}) {
      const double share = (u + zeta * along_u).cross(v + zeta * along_v).dot(middle) / u.cross(v).dot(middle);
      if (share < thinnest) thinnest = share, worst = t;
    }
  }
  const Eigen::RowVector3d sharpest = corners_of(mesh.nodes, mesh.cells, worst)[0];
  const std::string where = "thickness_m = " + length_text(thickness_m) + ", the sharpest bend is at triangle " +
                            std::to_string(worst) + " (" + length_text(sharpest[0]) + ", " + length_text(sharpest[1]) +
                            ", " + length_text(sharpest[2]) + ")";
  if (thinnest < thickest_layer)
    throw input_error(source + ": the wall is so thick that its inner face intersects itself at a bend", where,
                      "make the wall thinner, round the bend, or simulate a solid, without thickness_m");
  if (thinnest < thick_layer)
    result.warnings.push_back(
        "the wall is thicker than half the radius of a bend, for which a solid would be more "
        "accurate than a shell; " +
        where);
}

}  // namespace phynness::meshes
