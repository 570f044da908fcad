#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <phynness/meshes/meshes.hpp>
#include <sstream>

#include "geometry.hpp"

namespace phynness {
namespace {

double quality_of(const Mesh& mesh, std::int32_t c) {
  const auto x = [&](int k) -> Eigen::RowVector3d {
    return mesh.nodes.row(mesh.cells(c, k)) - mesh.nodes.row(mesh.cells(c, 0));
  };
  return mesh.cells.cols() == 4 ? meshes::radius_ratio(x(1), x(2), x(3)) : meshes::radius_ratio(x(1), x(2));
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
  const auto corners = static_cast<int>(mesh.cells.cols());
  for (std::int32_t c = 0; c < mesh.n_cells(); ++c) {
    const auto cell = mesh.cells.row(c);
    const Eigen::RowVector3d a = mesh.nodes.row(cell(0));
    const Eigen::RowVector3d u = mesh.nodes.row(cell(1)) - a, v = mesh.nodes.row(cell(2)) - a;
    if (corners == 4)
      report.volume_m3 += u.dot(v.cross(mesh.nodes.row(cell(3)) - a)) / 6;
    else
      report.area_m2 += u.cross(v).norm() / 2;
    const double quality = quality_of(mesh, c);
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

CellsAcross cells_across(const Mesh& mesh, const std::vector<std::int32_t>& nodes) {
  const Points normals = node_normals(mesh);
  const double edge_m = measure_quality(mesh).mean_edge_m;
  std::vector<std::pair<double, std::int32_t>> found;
  for (const auto node : nodes) {
    const Eigen::RowVector3d from = mesh.nodes.row(node), inward = -normals.row(node);
    double way_m = std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.surface.rowwise()) {
      if ((t.array() == node).any()) continue;
      // The way meets a triangle where the three volumes with its edges have one sign.
      const Eigen::RowVector3d a = mesh.nodes.row(t[0]) - from, b = mesh.nodes.row(t[1]) - from,
                               c = mesh.nodes.row(t[2]) - from, normal = (b - a).cross(c - a);
      const bool leaves = inward.dot(normal) > 0 && a.dot(normal) > 0 && inward.dot(a.cross(b)) >= 0 &&
                          inward.dot(b.cross(c)) >= 0 && inward.dot(c.cross(a)) >= 0;
      if (leaves) way_m = std::min(way_m, a.dot(normal) / inward.dot(normal));
    }
    if (std::isfinite(way_m)) found.emplace_back(way_m / edge_m, node);
  }
  if (found.empty()) return {};
  std::ranges::sort(found);
  return {found.front().first, found[found.size() / 2].first, found.front().second};
}

std::string CellQuality::str(double per_m, const char* unit) const {
  std::ostringstream text;
  text.precision(3);
  text << "cell " << cell << ": quality " << quality << ", at (" << per_m * center_m[0] << ", " << per_m * center_m[1]
       << ", " << per_m * center_m[2] << ")" << unit << ", " << on_surface << " of its " << corners
       << " nodes on the surface";
  if (fixed > 0) text << ", " << fixed << " fixed";
  return text.str();
}

CellQuality cell_quality(const Mesh& mesh, std::int32_t cell, const NodeList& fixed) {
  CellQuality result{cell, quality_of(mesh, cell), {}, static_cast<int>(mesh.cells.cols())};
  const auto surface = surface_nodes(mesh.surface);
  for (const std::int32_t node : mesh.cells.row(cell)) {
    for (int k = 0; k < 3; ++k) result.center_m[k] += mesh.nodes(node, k) / result.corners;
    result.on_surface += std::binary_search(surface.begin(), surface.end(), node);
    result.fixed += std::binary_search(fixed.begin(), fixed.end(), node);
  }
  return result;
}

std::vector<CellQuality> worst_cells(const Mesh& mesh, const NodeList& fixed, std::size_t count) {
  std::vector<std::int32_t> cells(static_cast<std::size_t>(mesh.n_cells()));
  std::iota(cells.begin(), cells.end(), 0);
  std::vector<double> quality;
  for (const auto c : cells) quality.push_back(quality_of(mesh, c));
  const auto end = cells.begin() + std::min(std::ssize(cells), static_cast<std::ptrdiff_t>(count));
  std::partial_sort(cells.begin(), end, cells.end(), [&](auto a, auto b) {
    return std::pair{quality[static_cast<std::size_t>(a)], a} < std::pair{quality[static_cast<std::size_t>(b)], b};
  });
  std::vector<CellQuality> worst;
  for (auto c = cells.begin(); c != end; ++c) worst.push_back(cell_quality(mesh, *c, fixed));
  return worst;
}

}  // namespace phynness
