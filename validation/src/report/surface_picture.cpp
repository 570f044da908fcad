#include "surface_picture.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace phynness::report {
namespace {

constexpr double width = 460, margin = 10;
/// More triangles than this are drawn as every n-th: a page is no viewer.
constexpr std::size_t most_triangles = 20000;

/// Dark blue, green, yellow: equal steps look equal, also to eyes that confuse red and green.
std::array<double, 3> color(double t) {
  static constexpr std::array<std::array<double, 3>, 5> stops{
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = std::clamp(t, 0.0, 1.0) * (stops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  std::array<double, 3> rgb{};
  for (std::size_t k = 0; k < 3; ++k)
    rgb[k] = stops[low][k] + (at - static_cast<double>(low)) * (stops[low + 1][k] - stops[low][k]);
  return rgb;
}

std::string css(const std::array<double, 3>& rgb, double light = 1) {
  return fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(light * rgb[0]),
                     static_cast<int>(light * rgb[1]), static_cast<int>(light * rgb[2]));
}

struct Face {
  double depth;
  std::string polygon;
};

}  // namespace

std::string surface_picture(const Model& model, const std::vector<double>& value,
                            const std::vector<std::int32_t>& marks, const std::string& unit) {
  const auto n_output = static_cast<std::int32_t>(model.output.size());
  const auto position = [&](std::int32_t node, double& v, bool& fixed) -> Eigen::RowVector3d {
    const auto out = std::lower_bound(model.output.begin(), model.output.end(), node);
    fixed = out == model.output.end() || *out != node;
    if (!fixed) {
      v = value[static_cast<std::size_t>(out - model.output.begin())];
      return model.output_points.row(out - model.output.begin());
    }
    v = 0;
    const auto at = std::lower_bound(model.fixed.begin(), model.fixed.end(), node);
    return model.fixed_points.row(at - model.fixed.begin());
  };
  if (model.surface.rows() == 0 || n_output == 0) return "<p>The model has no triangles.</p>";
  const Eigen::RowVector3d low = model.output_points.colwise().minCoeff(),
                           high = model.output_points.colwise().maxCoeff();
  std::array<int, 3> axes{0, 1, 2};
  std::sort(axes.begin(), axes.end(), [&](int a, int b) { return high[a] - low[a] > high[b] - low[b]; });
  const double scale = (width - 2 * margin) / std::max(1e-300, high[axes[0]] - low[axes[0]]);
  const double height = std::max(40.0, scale * (high[axes[1]] - low[axes[1]]) + 2 * margin);
  std::vector<double> sorted = value;
  std::sort(sorted.begin(), sorted.end());
  // The largest few would make all else dark.
  const double top =
      std::max(1e-300, sorted[static_cast<std::size_t>(0.98 * static_cast<double>(sorted.size() - 1))]);
  const auto n_triangles = static_cast<std::size_t>(model.surface.rows());
  const std::size_t stride = 1 + n_triangles / most_triangles;
  std::string out = "<div class=\"plots\">\n";
  for (const double side : {1.0, -1.0}) {
    std::vector<Face> faces;
    const auto place = [&](const Eigen::RowVector3d& x) {
      const double across = scale * (x[axes[0]] - low[axes[0]]), up = scale * (x[axes[1]] - low[axes[1]]);
      return std::array<double, 2>{side > 0 ? margin + across : width - margin - across,
                                   height - margin - up};
    };
    for (std::size_t t = 0; t < n_triangles; t += stride) {
      std::array<Eigen::RowVector3d, 3> x;
      double mean = 0;
      int n_fixed = 0;
      for (int k = 0; k < 3; ++k) {
        double v = 0;
        bool fixed = false;
        x[static_cast<std::size_t>(k)] = position(model.surface(static_cast<Eigen::Index>(t), k), v, fixed);
        mean += v / 3;
        n_fixed += fixed;
      }
      const Eigen::RowVector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
      // Axes may be a mirrored set: what counts is which way the normal points along the line of sight.
      const double facing = side * normal[axes[2]] / std::max(1e-300, normal.norm());
      if (facing <= 0) continue;
      const double light = 0.65 + 0.35 * facing;
      std::string points;
      for (const auto& corner : x) {
        const auto p = place(corner);
        points += fmt::format("{:.1f},{:.1f} ", p[0], p[1]);
      }
      const std::string fill = n_fixed == 3 ? css({150, 150, 150}, light) : css(color(mean / top), light);
      faces.push_back(
          {side * (x[0] + x[1] + x[2])[axes[2]],
           fmt::format("<polygon points=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"0.4\"/>\n", points,
                       fill, fill)});
    }
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.depth < b.depth; });
    out += fmt::format("<figure><svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"surface\">\n",
                       width, height);
    for (const auto& face : faces) out += face.polygon;
    for (const std::int32_t mark : marks) {
      const auto p = place(model.output_points.row(mark));
      out += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"none\" stroke=\"#fff\" "
          "stroke-width=\"1.5\"/>\n",
          p[0], p[1]);
    }
    out += fmt::format("</svg><figcaption>{} along {}</figcaption></figure>\n",
                       side > 0 ? "Seen from above" : "Seen from below", "xyz"[axes[2]]);
  }
  out += "</div>\n<svg viewBox=\"0 0 460 34\" width=\"460\" role=\"img\" aria-label=\"scale\">\n";
  for (int i = 0; i < 60; ++i)
    out += fmt::format("<rect x=\"{}\" y=\"2\" width=\"5.2\" height=\"10\" fill=\"{}\"/>\n", 60 + 5 * i,
                       css(color(i / 59.0)));
  out += fmt::format(
      "<text x=\"60\" y=\"27\" font-size=\"12\" fill=\"currentColor\">0</text><text x=\"360\" y=\"27\" "
      "font-size=\"12\" "
      "text-anchor=\"end\" fill=\"currentColor\">{:.3g} {}</text>\n</svg>\n",
      top, unit);
  return out;
}

}  // namespace phynness::report
