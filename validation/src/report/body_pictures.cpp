// Pictures of the body in a report: errors as colours, and the worst cases as the finite elements and the model
// displace it, side by side.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <phynness/validation/report.hpp>

#include "blocks.hpp"

namespace phynness::report {
namespace {

constexpr double width = 480, unknown = std::numeric_limits<double>::quiet_NaN();

/// Of 0 to 1: every second colour of web/shared/src/colour_maps.ts, as .scale of web/pages/report.css has them; darker
/// in the shade.
std::string colour(double share, double light) {
  constexpr int of[5][3] = {{31, 24, 93}, {44, 86, 136}, {79, 144, 142}, {154, 195, 120}, {255, 235, 80}};
  const double at = 4 * std::clamp(share, 0.0, 1.0);
  const int k = std::min(3, static_cast<int>(at));
  const auto part = [&](int c) { return std::lround(light * (of[k][c] + (at - k) * (of[k + 1][c] - of[k][c]))); };
  return fmt::format("#{:02x}{:02x}{:02x}", part(0), part(1), part(2));
}

/// The surface of a model, seen from the front and above without perspective.
class Surface {
 public:
  explicit Surface(const Validated& in) : _n_output(in.model.model().output_points.rows()) {
    const Model& model = in.model.model();
    for (const auto* nodes : {&model.output, &model.fixed})
      for (const auto node : *nodes) rows.emplace(node, static_cast<std::int32_t>(rows.size()));
    _points.resize(std::ssize(rows), 3);
    _points << model.output_points, model.fixed_points;
    for (const auto& corners : model.surface.rowwise())
      _triangles.push_back({rows.at(corners[0]), rows.at(corners[1]), rows.at(corners[2])});
    _is_closed = in.model.mesh().cells.cols() == 4;
    using Turn = Eigen::AngleAxisd;
    constexpr double degree = std::numbers::pi / 180;
    _view = (Turn(-58 * degree, Eigen::Vector3d::UnitX()) * Turn(-25 * degree, Eigen::Vector3d::UnitZ()))
                .toRotationMatrix();
    const Points projected = _points * _view.transpose();
    _low = projected.colwise().minCoeff();
    _size = projected.colwise().maxCoeff() - _low;
  }

  /// @param values  of the output nodes; NaN: not known. @param moved  output nodes, n x 3 [m]; no rows: at rest
  /// @param touched  an output node with a tool, or -1
  std::string svg(const std::vector<double>& values, double largest, const Points& moved = Points(0, 3),
                  Eigen::Index touched_row = -1) const {
    Points points = _points;
    points.topRows(moved.rows()) += moved;
    const double margin = 0.1 * width, scale = 0.8 * width / std::max(_size[0], 1e-300);
    const Points projected = points * _view.transpose();
    const auto x = [&](Eigen::Index i) { return margin + scale * (projected(i, 0) - _low[0]); };
    const auto y = [&](Eigen::Index i) { return margin + scale * (_low[1] + _size[1] - projected(i, 1)); };
    std::vector<std::pair<double, std::string>> triangles_by_depth;  // by their distance, the farthest first
    for (const auto& [a, b, c] : _triangles) {
      const Eigen::RowVector3d normal =
          (projected.row(b) - projected.row(a)).cross(projected.row(c) - projected.row(a));
      const double facing = normal[2] / std::max(normal.norm(), 1e-300);
      if (_is_closed && facing <= 0) continue;
      double sum = 0, n = 0;
      for (const auto corner : {a, b, c})
        if (corner < _n_output && !std::isnan(values[static_cast<std::size_t>(corner)]))
          sum += values[static_cast<std::size_t>(corner)], ++n;
      const bool is_fixed = std::min({a, b, c}) >= _n_output;
      const auto fill = is_fixed ? "#70757c"
                        : n == 0 ? "#b8bcc2"
                                 : colour(sum / n / largest, 0.7 + 0.3 * std::abs(facing));
      triangles_by_depth.emplace_back(
          projected(a, 2) + projected(b, 2) + projected(c, 2),
          fmt::format(R"(<path d="M{:.1f} {:.1f}L{:.1f} {:.1f} {:.1f} {:.1f}z" fill="{}" stroke="{}"/>)", x(a), y(a),
                      x(b), y(b), x(c), y(c), fill, fill));
    }
    std::stable_sort(triangles_by_depth.begin(), triangles_by_depth.end(),
                     [](const auto& p, const auto& q) { return p.first < q.first; });
    std::string all =
        fmt::format(R"(<svg class="body" viewBox="0 0 {} {:.0f}" role="img">)", width, 2 * margin + scale * _size[1]);
    for (const auto& [depth, path] : triangles_by_depth) all += path;
    if (touched_row >= 0)
      all += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="6"/>)", x(touched_row), y(touched_row));
    return all + "</svg>";
  }

  std::map<std::int32_t, std::int32_t> rows;  ///< of nodes: output nodes, then fixed nodes

 private:
  Points _points;
  std::vector<std::array<Eigen::Index, 3>> _triangles;
  Eigen::Index _n_output;
  bool _is_closed = true;
  Eigen::Matrix3d _view;  ///< to the right, up, and towards the viewer
  Eigen::RowVector3d _low, _size;
};

Json picture(const Surface& surface, const std::string& caption, const std::vector<double>& values) {
  double high = 0;
  for (const double value : values) high = std::max(high, std::isnan(value) ? 0 : value);
  return {{"svg", surface.svg(values, high > 0 ? high : 1)},
          {"caption", caption},
          {"scale", {"0", in_percent(high) + " %"}}};
}

/// Values of some nodes by output node.
std::vector<double> by_output(const Surface& surface, std::size_t n_output, const auto& of_nodes) {
  std::vector<double> values(n_output, unknown);
  for (const auto& [node, value] : of_nodes)
    if (const auto row = static_cast<std::size_t>(surface.rows.at(node)); row < n_output) values[row] = value;
  return values;
}

}  // namespace

std::vector<Json> body_pictures(const Validated& in) {
  const Model& model = in.model.model();
  if (model.surface.rows() == 0 || in.report.shown.empty()) return {};
  const Surface surface(in);
  const std::size_t n = model.output.size();
  std::vector<std::pair<std::int32_t, double>> forces, not_trained;
  for (const auto& node : in.report.to_range.nodes) forces.emplace_back(node.node, node.force);
  const auto share = trained_share(model);
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    not_trained.emplace_back(model.nodes[i].node, 1 - share.of_node[i]);
  std::vector<Json> all{
      picture(surface, "Mean error of the displacement", in.report.output_error),
      picture(surface, "Mean error of the force at the probed nodes; grey: not probed", by_output(surface, n, forces))};
  if (share.all < 1)
    all.push_back(picture(surface, "Share of the probe volume beyond the trained range; grey: not probed",
                          by_output(surface, n, not_trained)));
  for (std::size_t i = 0; i < in.report.shown.size(); ++i) {
    const auto& state = in.report.shown[i];
    const auto& d = state.displacement_m;
    const Eigen::VectorXd off = (state.model_m - state.finite_elements_m).rowwise().norm();
    const double high = std::max(off.maxCoeff(), 1e-300);
    for (const auto& [who, moved] : {std::pair{"Finite elements", &state.finite_elements_m}, {"Model", &state.model_m}})
      all.push_back(
          {{"svg", surface.svg({off.begin(), off.end()}, high, *moved, surface.rows.at(state.node))},
           {"case", i},
           {"caption", fmt::format("{}, node {} displaced by {:.3g} mm, coloured by the distance between both", who,
                                   state.node, 1e3 * std::hypot(d[0], d[1], d[2]))},
           {"scale", {"0", fmt::format("{:.2g} mm", 1e3 * high)}}});
    all.back().erase("case");
  }
  return all;
}

}  // namespace phynness::report
