#include "surface_picture.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace phynness::report {
namespace {

constexpr double width = 460, margin = 10;
/// Of more triangles than this only every n-th is drawn, which limits the size of the page.
constexpr std::size_t most_triangles = 20000;

/// Dark blue, green, yellow: the colours are perceptually uniform, also with red-green colour blindness.
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
  return fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(light * rgb[0]), static_cast<int>(light * rgb[1]),
                     static_cast<int>(light * rgb[2]));
}

struct Face {
  double depth;
  std::string polygon;
};

/// The surface of a model, seen along its shortest axis.
class Picture {
 public:
  Picture(const Model& model, const std::vector<double>& value) : _model(model), _value(value) {
    _low = model.output_points.colwise().minCoeff();
    const Eigen::RowVector3d high = model.output_points.colwise().maxCoeff();
    std::sort(_axes.begin(), _axes.end(), [&](int a, int b) { return high[a] - _low[a] > high[b] - _low[b]; });
    _scale = (width - 2 * margin) / std::max(1e-300, high[_axes[0]] - _low[_axes[0]]);
    _height = std::max(40.0, _scale * (high[_axes[1]] - _low[_axes[1]]) + 2 * margin);
    std::vector<double> sorted = value;
    std::sort(sorted.begin(), sorted.end());
    // The scale ends below the few largest values, because otherwise all other values would be dark.
    _top = std::max(1e-300, sorted[static_cast<std::size_t>(0.98 * static_cast<double>(sorted.size() - 1))]);
  }

  /// @param side  1: seen from above, -1: from below
  std::string view(double side, const std::vector<std::int32_t>& marks) const {
    const auto n_triangles = _model.surface.rows();
    const auto stride = static_cast<Eigen::Index>(1 + static_cast<std::size_t>(n_triangles) / most_triangles);
    std::vector<Face> faces;
    for (Eigen::Index t = 0; t < n_triangles; t += stride)
      if (auto face = seen(t, side)) faces.push_back(std::move(*face));
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.depth < b.depth; });
    auto out = fmt::format("<figure><svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"surface\">\n", width,
                           _height);
    for (const auto& face : faces) out += face.polygon;
    for (const std::int32_t mark : marks) {
      const auto p = place(_model.output_points.row(mark), side);
      out += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"none\" stroke=\"#fff\" "
          "stroke-width=\"1.5\"/>\n",
          p[0], p[1]);
    }
    return out + fmt::format("</svg><figcaption>{} along {}</figcaption></figure>\n",
                             side > 0 ? "Seen from above" : "Seen from below", "xyz"[_axes[2]]);
  }

  std::string color_scale(const std::string& unit) const {
    std::string out = "<svg viewBox=\"0 0 460 34\" width=\"460\" role=\"img\" aria-label=\"scale\">\n";
    for (int i = 0; i < 60; ++i)
      out += fmt::format("<rect x=\"{}\" y=\"2\" width=\"5.2\" height=\"10\" fill=\"{}\"/>\n", 60 + 5 * i,
                         css(color(i / 59.0)));
    return out + fmt::format(
                     "<text x=\"60\" y=\"27\" font-size=\"12\" fill=\"currentColor\">0</text><text x=\"360\" "
                     "y=\"27\" font-size=\"12\" "
                     "text-anchor=\"end\" fill=\"currentColor\">{:.3g} {}</text>\n</svg>\n",
                     _top, unit);
  }

 private:
  Eigen::RowVector3d position(std::int32_t node, double& v, bool& fixed) const {
    const auto out = std::lower_bound(_model.output.begin(), _model.output.end(), node);
    fixed = out == _model.output.end() || *out != node;
    if (!fixed) {
      v = _value[static_cast<std::size_t>(out - _model.output.begin())];
      return _model.output_points.row(out - _model.output.begin());
    }
    v = 0;
    const auto at = std::lower_bound(_model.fixed.begin(), _model.fixed.end(), node);
    return _model.fixed_points.row(at - _model.fixed.begin());
  }

  std::array<double, 2> place(const Eigen::RowVector3d& x, double side) const {
    const double across = _scale * (x[_axes[0]] - _low[_axes[0]]), up = _scale * (x[_axes[1]] - _low[_axes[1]]);
    return {side > 0 ? margin + across : width - margin - across, _height - margin - up};
  }

  /// Empty if the triangle faces away from the viewer.
  std::optional<Face> seen(Eigen::Index triangle, double side) const {
    std::array<Eigen::RowVector3d, 3> x;
    double mean = 0;
    int n_fixed = 0;
    for (int k = 0; k < 3; ++k) {
      double v = 0;
      bool fixed = false;
      x[static_cast<std::size_t>(k)] = position(_model.surface(triangle, k), v, fixed);
      mean += v / 3;
      n_fixed += fixed;
    }
    const Eigen::RowVector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
    // The axes may be left-handed, so the direction of the normal along the line of sight decides.
    const double facing = side * normal[_axes[2]] / std::max(1e-300, normal.norm());
    if (facing <= 0) return std::nullopt;
    const double light = 0.65 + 0.35 * facing;
    std::string points;
    for (const auto& corner : x) {
      const auto p = place(corner, side);
      points += fmt::format("{:.1f},{:.1f} ", p[0], p[1]);
    }
    const std::string fill = n_fixed == 3 ? css({150, 150, 150}, light) : css(color(mean / _top), light);
    return Face{
        side * (x[0] + x[1] + x[2])[_axes[2]],
        fmt::format("<polygon points=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"0.4\"/>\n", points, fill, fill)};
  }

  const Model& _model;
  const std::vector<double>& _value;
  Eigen::RowVector3d _low;
  std::array<int, 3> _axes{0, 1, 2};
  double _scale = 0, _height = 0, _top = 0;
};

}  // namespace

std::string surface_picture(const Model& model, const std::vector<double>& value,
                            const std::vector<std::int32_t>& marks, const std::string& unit) {
  if (model.surface.rows() == 0 || model.output.empty()) return "<p>The model has no triangles.</p>";
  const Picture picture(model, value);
  return "<div class=\"plots\">\n" + picture.view(1, marks) + picture.view(-1, marks) + "</div>\n" +
         picture.color_scale(unit);
}

}  // namespace phynness::report
