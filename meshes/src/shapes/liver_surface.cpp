#include <cmath>
#include <map>

#include "generate.hpp"

namespace phynness::meshes {
namespace {

constexpr int subdivisions = 5;  // 10,242 nodes: finer than practical meshes

/// Icosahedron on the unit sphere whose triangles are repeatedly divided into four.
Surface unit_sphere() {
  const double t = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::RowVector3d> x = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                                       {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  for (auto& p : x) p.normalize();
  std::vector<Triangle> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < subdivisions; ++level) {
    std::map<Edge, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [found, is_new] = middles.emplace(edge_of(a, b), static_cast<std::int32_t>(x.size()));
      if (is_new) x.push_back((x[a] + x[b]).normalized());
      return found->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  Surface sphere;
  sphere.nodes.resize(static_cast<Eigen::Index>(x.size()), 3);
  for (std::size_t i = 0; i < x.size(); ++i) sphere.nodes.row(static_cast<Eigen::Index>(i)) = x[i];
  sphere.triangles = to_matrix(triangles);
  return sphere;
}

double smooth_step(double from, double to, double u) {
  const double s = std::clamp((u - from) / (to - from), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// Map from the sphere (u, v, w) to the organ. x depends on u alone, y increases with v, and z increases with w. The
/// map is therefore one to one, and the surface of the organ cannot intersect itself.
Eigen::RowVector3d organ_point(double u, double v, double w) {
  const double left = smooth_step(-0.5, 1.0, u);  // 0 in the right lobe, 1 at the tip of the left one
  const double half_width = 1.0 - 0.45 * left;
  const double notch = 0.16 * std::exp(-std::pow((u - 0.25) / 0.16, 2)) * std::pow(std::max(0.0, -v), 2);
  const double y = half_width * v + 0.18 * left + notch;
  const double half_thickness = (0.34 - 0.15 * left) * (1.0 + 0.25 * v);  // thick behind, thinner in front
  const double dome = -0.45 * (u + 0.25) * (u + 0.25) - 0.375 * v * v;
  // The rim is round, because a sharp one would result in flat cells.
  const double blunt = w / std::sqrt(w * w + 0.2 * (1 - w * w));
  return {u, y, dome + half_thickness * blunt};
}

}  // namespace

Surface liver_surface(const Vec3& size_m) {
  Surface liver = unit_sphere();
  for (Eigen::Index i = 0; i < liver.nodes.rows(); ++i)
    liver.nodes.row(i) = organ_point(liver.nodes(i, 0), liver.nodes(i, 1), liver.nodes(i, 2));
  for (int k = 0; k < 3; ++k) {
    const double low = liver.nodes.col(k).minCoeff(), high = liver.nodes.col(k).maxCoeff();
    liver.nodes.col(k) = (liver.nodes.col(k).array() - (low + high) / 2) * (size_m[k] / (high - low));
  }
  return liver;
}

}  // namespace phynness::meshes
