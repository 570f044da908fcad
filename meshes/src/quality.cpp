#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <phynness/meshes/meshes.hpp>

#include "geometry.hpp"

namespace phynness {
QualityReport measure_quality(const Mesh& mesh) {
  QualityReport report;
  report.n_nodes = mesh.n_nodes();
  report.n_cells = mesh.n_cells();
  report.n_surface_nodes = static_cast<std::int32_t>(surface_nodes(mesh.surface).size());
  report.n_surface_triangles = static_cast<std::int32_t>(mesh.surface.rows());
  if (mesh.nodes.rows() == 0 || mesh.cells.rows() == 0) return report;
  for (int k = 0; k < 3; ++k) {
    report.min_m[k] = mesh.nodes.col(k).minCoeff();
    report.max_m[k] = mesh.nodes.col(k).maxCoeff();
  }
  report.min_quality = std::numeric_limits<double>::infinity();
  const auto corners = static_cast<int>(mesh.cells.cols());
  for (std::int32_t c = 0; c < mesh.n_cells(); ++c) {
    const auto cell = mesh.cells.row(c);
    const Eigen::RowVector3d a = mesh.nodes.row(cell(0));
    const Eigen::RowVector3d u = mesh.nodes.row(cell(1)) - a, v = mesh.nodes.row(cell(2)) - a;
    double quality;
    if (corners == 4) {
      const Eigen::RowVector3d w = mesh.nodes.row(cell(3)) - a;
      report.volume_m3 += u.dot(v.cross(w)) / 6;
      quality = meshes::radius_ratio(u, v, w);
    } else {
      report.area_m2 += u.cross(v).norm() / 2;
      quality = meshes::radius_ratio(u, v);
    }
    report.n_slivers += quality < sliver_quality;
    if (quality < report.min_quality) {
      report.min_quality = quality;
      report.worst_cell = c;
    }
  }
  const auto edges = mesh_edges(mesh);
  report.min_edge_m = std::numeric_limits<double>::infinity();
  for (const auto& [i, j] : edges) {
    const double length = (mesh.nodes.row(i) - mesh.nodes.row(j)).norm();
    report.mean_edge_m += length / static_cast<double>(edges.size());
    report.min_edge_m = std::min(report.min_edge_m, length);
    report.max_edge_m = std::max(report.max_edge_m, length);
  }
  return report;
}

}  // namespace phynness
