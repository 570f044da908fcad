#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mesh_picture.hpp"

namespace phynness::report {
namespace {

constexpr int width = 4600, margin = 60;  // tenths of a point, so that coordinates are integers
constexpr int n_shades = 12;

}  // namespace

std::string mesh_picture(const Points& points, const Triangles& triangles) {
  const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  std::array<int, 3> axes{0, 1, 2};
  std::sort(axes.begin(), axes.end(), [&](int a, int b) { return high[a] - low[a] > high[b] - low[b]; });
  const double scale = (width - 2 * margin) / std::max(1e-300, high[axes[0]] - low[axes[0]]);
  const int height = static_cast<int>(scale * (high[axes[1]] - low[axes[1]])) + 2 * margin;
  const auto place = [&](std::int32_t vertex) {
    const auto x = points.row(vertex);
    return std::array<int, 2>{margin + static_cast<int>(std::lround(scale * (x[axes[0]] - low[axes[0]]))),
                              height - margin - static_cast<int>(std::lround(scale * (x[axes[1]] - low[axes[1]])))};
  };
  std::array<std::string, n_shades> paths;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    std::array<Eigen::RowVector3d, 3> x;
    for (int k = 0; k < 3; ++k) x[static_cast<std::size_t>(k)] = points.row(triangles(t, k));
    const Eigen::RowVector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
    const double facing = normal[axes[2]] / std::max(1e-300, normal.norm());
    if (facing <= 0) continue;
    const auto a = place(triangles(t, 0)), b = place(triangles(t, 1)), c = place(triangles(t, 2));
    auto& path = paths[static_cast<std::size_t>(std::min(n_shades - 1, static_cast<int>(n_shades * facing)))];
    path += fmt::format("M{} {}l{} {} {} {}z", a[0], a[1], b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]);
  }
  // Lines are limited to a fifth of the mean edge length, because they would cover a fine mesh.
  const double edge = width / std::sqrt(static_cast<double>(triangles.rows()));
  std::string out = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\">\n", width, height);
  for (int s = 0; s < n_shades; ++s) {
    const int grey = 110 + 130 * s / (n_shades - 1);
    out += fmt::format(
        "<path d=\"{}\" fill=\"#{:02x}{:02x}{:02x}\" stroke=\"#234\" stroke-width=\"{:.1f}\" "
        "stroke-linejoin=\"round\"/>\n",
        paths[static_cast<std::size_t>(s)], grey - 20, grey - 10, grey, std::min(8.0, 0.06 * edge));
  }
  return out + "</svg>";
}

}  // namespace phynness::report
