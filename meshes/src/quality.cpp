#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <phynness/meshes/meshes.hpp>

namespace phynness {
namespace {

/// Radius ratio 3 r_in / r_circ of a tetrahedron with edges u, v, w from one node: r_in = 3 V / A,
/// r_circ = |u^2 (v x w) + v^2 (w x u) + w^2 (u x v)| / (12 V).
double radius_ratio(const Eigen::RowVector3d& u, const Eigen::RowVector3d& v, const Eigen::RowVector3d& w) {
  const Eigen::RowVector3d vw = v.cross(w), wu = w.cross(u), uv = u.cross(v);
  const double volume = u.dot(vw) / 6;
  const double total_area = (vw.norm() + wu.norm() + uv.norm() + (v - u).cross(w - u).norm()) / 2;
  const double twelve_v_r = (u.squaredNorm() * vw + v.squaredNorm() * wu + w.squaredNorm() * uv).norm();
  if (!(total_area > 0) || !(twelve_v_r > 0)) return 0;
  return 108 * volume * volume / (total_area * twelve_v_r);
}

}  // namespace

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
  std::vector<std::array<std::int32_t, 2>> edges;
  for (std::int32_t c = 0; c < mesh.n_cells(); ++c) {
    const auto cell = mesh.cells.row(c);
    const Eigen::RowVector3d a = mesh.nodes.row(cell(0));
    const Eigen::RowVector3d u = mesh.nodes.row(cell(1)) - a, v = mesh.nodes.row(cell(2)) - a,
                             w = mesh.nodes.row(cell(3)) - a;
    report.volume_m3 += u.dot(v.cross(w)) / 6;
    const double quality = radius_ratio(u, v, w);
    report.n_slivers += quality < sliver_quality;
    if (quality < report.min_quality) {
      report.min_quality = quality;
      report.worst_cell = c;
    }
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) edges.push_back({std::min(cell(i), cell(j)), std::max(cell(i), cell(j))});
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
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
