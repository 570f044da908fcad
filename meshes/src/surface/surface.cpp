#include "surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <set>

#include "geometry.hpp"
#include "read/file_mesh.hpp"

namespace phynness::meshes {
namespace {

void drop_repeated_triangles(RawMesh& raw, std::vector<std::string>& notes) {
  std::set<Triangle> seen;
  const auto n = std::erase_if(raw.triangles, [&](Triangle key) {
    std::sort(key.begin(), key.end());
    return !seen.insert(key).second;
  });
  if (n > 0) notes.push_back("repair: dropped " + counted(n, "repeated triangle", "repeated triangles"));
}

}  // namespace

double enclosed_volume(const Points& nodes, const Triangles& triangles) {
  if (nodes.rows() == 0) return 0;
  const Eigen::RowVector3d origin = nodes.colwise().mean();  // near the body, which reduces cancellation
  double six_volumes = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto [a, b, c] = corners_of(nodes, triangles, t);
    six_volumes += (a - origin).dot((b - origin).cross(c - origin));
  }
  return six_volumes / 6;
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
  drop_useless_triangles(raw, notes);
  if (repair) drop_repeated_triangles(raw, notes);
  if (raw.triangles.empty())
    throw input_error(source + ": the surface has no triangle with three different corners", counts,
                      "export a closed surface");
  SurfaceTopology topology = surface_topology(to_matrix(raw.triangles));
  if (repair && topology.component_sizes.size() > 1) {
    keep_largest(raw.triangles, topology.component, topology.component_sizes, "triangles", notes);
    topology = surface_topology(to_matrix(raw.triangles));
  }
  if (const std::string defects = describe_defects(topology, true); !defects.empty())
    throw input_error(
        source + ": the surface is not one closed manifold, so it has no inside to fill", defects,
        topology.closed_manifold()
            ? "keep one component, or set mesh.repair = true to keep the largest"
            : std::string("close the holes and separate parts that touch in the program that made the file") +
                  (repair || topology.component_sizes.size() < 2
                       ? ""
                       : "; mesh.repair = true keeps the largest component, if this component has no defects"));

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
