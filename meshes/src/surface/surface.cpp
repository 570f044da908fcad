#include "surface.hpp"

#include <Eigen/Geometry>
#include <phynness/formats/error.hpp>

#include "geometry.hpp"
#include "read/file_mesh.hpp"

namespace phynness::meshes {
namespace {

/// Six times the volume between a triangle and a point.
double six_volumes(const Points& nodes, const Triangles& triangles, Eigen::Index t, const Eigen::RowVector3d& origin) {
  const auto [a, b, c] = corners_of(nodes, triangles, t);
  return (a - origin).dot((b - origin).cross(c - origin));
}

}  // namespace

void keep_largest_surface(RawMesh& raw, SurfaceTopology& topology) {
  if (topology.component_sizes.size() < 2) return;
  std::vector<double> sizes;
  const Points nodes = to_points(raw.nodes);
  Triangles triangles = to_matrix(raw.triangles);
  const bool closed = topology.open_edges.empty() && topology.non_manifold_edges.empty() &&
                      orient_consistently(triangles, topology) >= 0;
  const Eigen::RowVector3d origin = nodes.colwise().mean();
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto [a, b, c] = corners_of(nodes, triangles, t);
    sizes.push_back(closed ? six_volumes(nodes, triangles, t, origin) / 6 : (b - a).cross(c - a).norm() / 2);
  }
  keep_largest(raw.triangles, topology, "triangles", sizes, closed ? "m^3" : "m^2", raw.notes);
  topology = surface_topology(to_matrix(raw.triangles));
}

double enclosed_volume(const Points& nodes, const Triangles& triangles) {
  if (nodes.rows() == 0) return 0;
  const Eigen::RowVector3d origin = nodes.colwise().mean();  // near the body, which reduces cancellation
  double sum = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) sum += six_volumes(nodes, triangles, t, origin);
  return sum / 6;
}

double area(const Points& nodes, const Triangles& triangles) {
  double twice = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto [a, b, c] = corners_of(nodes, triangles, t);
    twice += (b - a).cross(c - a).norm();
  }
  return twice / 2;
}

double mean_edge(const Points& nodes, const Triangles& triangles) {
  double sum = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) sum += (nodes.row(triangles(t, k)) - nodes.row(triangles(t, (k + 1) % 3))).norm();
  return triangles.rows() == 0 ? 0 : sum / static_cast<double>(3 * triangles.rows());
}

bool orient(Triangles& triangles, const SurfaceTopology& topology, std::vector<std::string>& notes) {
  const std::int32_t turned = orient_consistently(triangles, topology);
  if (turned > 0)
    notes.push_back("turned " + counted(static_cast<std::size_t>(turned), "triangle", "triangles") +
                    " with orientations opposite to their neighbours");
  return turned >= 0;
}

Surface checked_surface(RawMesh raw, double scale_to_m, bool repair, const std::string& source,
                        std::vector<std::string>& notes) {
  scale(raw, scale_to_m);
  for (std::size_t i = 0; i < raw.nodes.size(); ++i)
    require_coordinates(raw.nodes[i], source + ": a vertex", static_cast<std::int64_t>(i));
  const std::string counts =
      counted(raw.triangles.size(), "triangle", "triangles") + ", " + counted(raw.nodes.size(), "vertex", "vertices");
  const std::string near = join_near_nodes(raw, repair);
  drop_useless_triangles(raw);
  if (raw.triangles.empty())
    throw input_error(source + ": the surface has no triangle with three different corners", counts,
                      "export a closed surface");
  SurfaceTopology topology = surface_topology(to_matrix(raw.triangles));
  if (repair) keep_largest_surface(raw, topology);
  notes.insert(notes.end(), raw.notes.begin(), raw.notes.end());
  if (const std::string defects = describe_defects(topology, true, raw.file_number); !defects.empty()) {
    const bool pieces = topology.component_sizes.size() > 1, closed = topology.closed_manifold();
    const bool holes = !closed && topology.non_manifold_edges.empty() && topology.pinched_nodes.empty();
    std::string remedy = "close the holes and separate parts that touch in the program that made the file";
    if (closed) remedy = "keep one of them, or set mesh.repair = true to keep the largest";
    if (holes && !pieces)
      remedy =
          "close the holes, as by Close Holes of MeshLab, or give mesh.thickness_m to simulate the surface as a shell";
    if (!closed && !near.empty()) remedy = "set mesh.repair = true to merge the near nodes; if holes remain, " + remedy;
    if (!closed && pieces && !repair)
      remedy = "set mesh.repair = true, which keeps the largest component if this has no defects; otherwise " + remedy;
    const char* const what = closed ? ": the file holds several closed surfaces"
                             : topology.open_edges.empty()
                                 ? ": the surface is not one closed manifold, so it has no inside to fill"
                                 : ": the surface is open, so it has no inside to fill";
    throw input_error(source + what, defects + (near.empty() || closed ? "" : "; " + near), remedy);
  }

  raw.tetrahedra.clear();
  raw.groups.clear();
  const std::size_t dropped = drop_unused_nodes(raw).size();
  Surface surface{to_points(raw.nodes), to_matrix(raw.triangles)};
  const std::size_t before = notes.size();
  if (!orient(surface.triangles, topology, notes))
    throw input_error(source + ": the surface is not orientable and has no inside", "",
                      "export a closed, orientable surface");
  double volume = enclosed_volume(surface.nodes, surface.triangles);
  if (volume < 0) {
    surface.triangles.col(1).swap(surface.triangles.col(2));
    volume = -volume;
    if (notes.size() == before) notes.push_back("turned all triangles: the normals pointed inward");
  }
  if (dropped > 0) notes.push_back("dropped " + counted(dropped, "vertex", "vertices") + " that no triangle uses");
  const double reach = extent_of(surface.nodes).norm();
  if (!(volume > 1e-12 * reach * reach * reach))
    throw input_error(source + ": the surface encloses no volume", std::to_string(volume) + " m^3",
                      "export a closed, solid shape");
  return surface;
}

}  // namespace phynness::meshes
