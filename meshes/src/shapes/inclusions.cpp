// Regions of a body at whose surface tetrahedra end.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <phynness/meshes/meshes.hpp>

#include "surface/closest_point.hpp"
#include "surface/geometry.hpp"

#include "generate.hpp"

namespace phynness::meshes {
namespace {

/// An icosahedron whose corners are at (0, +-1, +-golden ratio) and the cyclic permutations; triangles face outward.
Mesh icosahedron() {
  Mesh mesh;
  mesh.nodes.resize(12, 3);
  for (int i = 0; i < 12; ++i) {
    mesh.nodes(i, i % 3) = 0;
    mesh.nodes(i, (i + 1) % 3) = i / 3 % 2 == 0 ? 1 : -1;
    mesh.nodes(i, (i + 2) % 3) = i / 6 == 0 ? std::numbers::phi : -std::numbers::phi;
  }
  const auto is_edge = [&](int i, int j) { return (mesh.nodes.row(i) - mesh.nodes.row(j)).squaredNorm() < 4.1; };
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < i; ++j)
      for (int k = 0; k < j; ++k) {
        if (!is_edge(i, j) || !is_edge(j, k) || !is_edge(k, i)) continue;
        const bool outward = mesh.nodes.row(i).dot(mesh.nodes.row(j).cross(mesh.nodes.row(k))) > 0;
        triangles.push_back({i, outward ? j : k, outward ? k : j});
      }
  mesh.surface = to_matrix(triangles);
  mesh.cells = mesh.surface;
  return mesh;
}

Surface divided_ball(const Eigen::RowVector3d& center, const Eigen::RowVector3d& radii, double edge_m) {
  Mesh mesh = icosahedron();
  Surface surface;
  do {
    mesh = refined(mesh);
    mesh.nodes.rowwise().normalize();
    const double volume = enclosed_volume(mesh.nodes, mesh.surface), of_ball = 4 * std::numbers::pi / 3;
    surface = {std::cbrt(of_ball / volume) * mesh.nodes * radii.asDiagonal(), mesh.surface};
  } while (mean_edge(surface.nodes, surface.triangles) > edge_m);
  surface.nodes.rowwise() += center;
  return surface;
}

/// Whether gmsh can fill what is between two surfaces: nodes of the inner one are inside, and away by a part of an
/// edge.
bool is_apart(const Surface& inner, const Surface& outer, const ClosestPoint& closest, bool inside) {
  constexpr double least_distance = 0.2;
  const double least_m = least_distance * mean_edge(inner.nodes, inner.triangles);
  for (const auto& x : inner.nodes.rowwise())
    if (is_inside(outer, x) != inside || (closest(x) - x).norm() < least_m) return false;
  return true;
}

}  // namespace

/// Whether a point is inside of a closed surface: the solid angle that it fills is 4 pi (van Oosterom and Strackee
/// 1983, doi 10.1109/TBME.1983.325207).
bool is_inside(const Surface& surface, const Eigen::RowVector3d& x) {
  double half = 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    auto corners = corners_of(surface.nodes, surface.triangles, t);
    for (auto& corner : corners) corner = (corner - x).normalized().eval();
    const auto& [a, b, c] = corners;
    half += std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return half > std::numbers::pi;
}

bool can_be_inclusion(const Region& region) {
  const auto kind = region.cells.front().kind;
  return region.cells.size() == 1 && (kind == SelectorKind::sphere || kind == SelectorKind::ellipsoid);
}

std::string inclusion_group(std::size_t region) { return "phynness_inclusion_" + std::to_string(region); }

std::vector<Inclusion> inclusions(const std::vector<Region>& regions, const Surface& body, double edge_m) {
  std::vector<Inclusion> found;
  const Eigen::RowVector3d low = body.nodes.colwise().minCoeff(), extent = extent_of(body.nodes);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const Region& region = regions[r];
    if (!can_be_inclusion(region)) continue;
    const Selector& s = region.cells.front();
    Eigen::RowVector3d center = to_eigen(s.point).transpose(), radii = to_eigen(s.other).transpose();
    if (s.kind == SelectorKind::sphere) radii.setConstant(s.length_m);
    if (s.in_fractions) center = low + center.cwiseProduct(extent);
    Surface surface = divided_ball(center, radii, edge_m);
    bool apart = is_apart(surface, body, ClosestPoint(body), true);
    for (const Inclusion& other : found)
      apart = apart && is_apart(surface, other.surface, ClosestPoint(other.surface), false) &&
              is_apart(other.surface, surface, ClosestPoint(surface), false);
    if (apart) found.push_back({inclusion_group(r), std::move(surface)});
  }
  return found;
}

}  // namespace phynness::meshes
