#include "image_surface.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <map>
#include <phynness/formats/error.hpp>

namespace phynness {
namespace {

using Triangle = std::array<std::int32_t, 3>;

/// Position in an ascending list, or -1.
std::int32_t position(const std::vector<std::int32_t>& nodes, std::int32_t node) {
  const auto found = std::ranges::lower_bound(nodes, node);
  return found != nodes.end() && *found == node ? static_cast<std::int32_t>(found - nodes.begin()) : -1;
}
std::int32_t active_position(const Model& model, std::int32_t node) {
  const auto found = std::ranges::lower_bound(model.nodes, node, {}, &ActiveNodeModel::node);
  const bool is_active = found != model.nodes.end() && found->node == node;
  return is_active ? static_cast<std::int32_t>(found - model.nodes.begin()) : -1;
}

/// The active nodes and linear points between which a node of the surface lies. @return false: it can neither be
/// touched nor is fixed
bool find_corners(const Model& model, std::int32_t node, image::VertexCorners& corners) {
  const std::int32_t active = active_position(model, node);
  const std::uint16_t at = active < 0 ? image::none : static_cast<std::uint16_t>(active);
  corners = {{at, at, at}, schema::whole_weight, 0};
  if (active >= 0) return true;
  const auto rows = model.covered.col(0);
  const auto row = std::lower_bound(rows.begin(), rows.end(), node) - rows.begin();
  if (row == rows.size() || rows[row] != node) return position(model.fixed, node) >= 0;
  const std::int32_t triangle = model.covered(row, 1),
                     n_inner = static_cast<std::int32_t>(model.probe_triangles.rows());
  for (int k = 0; k < 3; ++k)
    corners.active[k] = static_cast<std::uint16_t>(triangle < n_inner ? model.probe_triangles(triangle, k)
                                                                      : model.outer_triangles(triangle - n_inner, k));
  corners.first = static_cast<std::uint16_t>(model.covered(row, 2));
  corners.second = static_cast<std::uint16_t>(model.covered(row, 3));
  return true;
}

/// Adds the touchable triangles' vertices to the surface. @return these triangles
std::vector<Triangle> touchable(const Model& model, ImageSurface& surface) {
  std::map<std::int32_t, std::int32_t> number;  // of a node among the vertices
  std::vector<std::int32_t> nodes;
  std::vector<Triangle> triangles;
  for (const auto& row : model.surface.rowwise()) {
    image::VertexCorners corners[3];
    bool all = true, moves = false;
    for (int k = 0; k < 3; ++k) {
      all = find_corners(model, row[k], corners[k]) && all;
      moves = moves || corners[k].active[0] != image::none;
    }
    if (!all || !moves) continue;
    auto& triangle = triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const auto [at, is_new] = number.try_emplace(row[k], static_cast<std::int32_t>(nodes.size()));
      triangle[static_cast<std::size_t>(k)] = at->second;
      if (!is_new) continue;
      nodes.push_back(row[k]);
      surface.vertex.push_back(corners[k]);
    }
  }
  surface.point.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t v = 0; v < nodes.size(); ++v) {
    const std::int32_t output = position(model.output, nodes[v]);
    surface.point.row(static_cast<Eigen::Index>(v)) =
        output >= 0 ? model.output_points.row(output) : model.fixed_points.row(position(model.fixed, nodes[v]));
  }
  return triangles;
}

/// Vertices and, across the edges opposite to them, the other triangle of the edge; none if there are not two that
/// traverse it in opposite directions.
std::vector<std::uint16_t> with_neighbours(const std::vector<Triangle>& triangles) {
  std::map<std::array<std::int32_t, 2>, std::vector<std::size_t>> edges;  // directed
  const auto edge = [&](std::size_t t, std::size_t k) {
    return std::array{triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]};
  };
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) edges[edge(t, k)].push_back(t);
  std::vector<std::uint16_t> all;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::int32_t v : triangles[t]) all.push_back(static_cast<std::uint16_t>(v));
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = edge(t, k);
      const auto found = edges.find({b, a});
      const bool one = found != edges.end() && found->second.size() == 1 && edges[{a, b}].size() == 1;
      all.push_back(one ? static_cast<std::uint16_t>(found->second[0]) : image::none);
    }
  }
  return all;
}

/// Halves of the least squares gradients of equation (x), as the parts of weights that neighbours take: mean_at in
/// runtime/src/tools/round_tool.cpp.
void find_gradients(const Model& model, ImageSurface& surface) {
  const std::size_t n_active = model.nodes.size();
  std::vector<std::map<std::int32_t, int>> shared(n_active +
                                                  model.linear_points.size());  // triangles with each neighbour
  const auto is_linear = [&](std::int32_t i) { return static_cast<std::size_t>(i) >= n_active; };
  const auto enter = [&](const std::array<std::int32_t, 3>& at, bool linear) {
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 1; l < 3; ++l) {
        const std::int32_t own = at[k], other = at[(k + l) % 3];
        if (own >= 0 && other >= 0 && own != other && is_linear(own) == linear && is_linear(other) == linear)
          ++shared[static_cast<std::size_t>(own)][other];
      }
  };
  const bool spread = model.probe_triangles.rows() > 0;
  for (const auto& row : (spread ? model.probe_triangles : model.surface).rowwise()) {
    std::array<std::int32_t, 3> at{};
    for (int k = 0; k < 3; ++k) at[static_cast<std::size_t>(k)] = spread ? row[k] : active_position(model, row[k]);
    enter(at, false);
  }
  for (const auto& row : model.outer_triangles.rowwise()) enter({row[0], row[1], row[2]}, true);
  const auto point = [&](std::size_t i) {
    const Vec3& x = i < n_active ? model.nodes[i].point : model.linear_points[i - n_active].point;
    return Eigen::Vector3d(Eigen::Vector3d::Map(x.data()));
  };
  std::vector<Eigen::Vector3d> slopes;
  surface.begin.push_back(0);
  for (std::size_t i = 0; i < shared.size(); ++i) {
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    int n = 0;
    const auto edge = [&](std::int32_t other) -> Eigen::Vector3d {
      return point(static_cast<std::size_t>(other)) - point(i);
    };
    for (const auto& [other, times] : shared[i]) {
      const Eigen::Vector3d e = edge(other);
      moment += times * e * e.transpose();
      n += times;
    }
    const double size = moment.trace();
    moment.diagonal().array() += schema::gradient_across * size;
    const bool few = n <= schema::most_neighbours && shared[i].size() <= image::most_neighbours;
    for (const auto& [other, times] : shared[i]) {
      if (!few || !(size > 0)) continue;
      surface.neighbour.push_back(static_cast<std::uint16_t>(other));
      slopes.emplace_back(0.5 * times * (moment.inverse() * edge(other)));
    }
    surface.begin.push_back(static_cast<std::uint32_t>(slopes.size()));
  }
  surface.slope.resize(static_cast<Eigen::Index>(slopes.size()), 3);
  for (std::size_t i = 0; i < slopes.size(); ++i) surface.slope.row(static_cast<Eigen::Index>(i)) = slopes[i];
}

}  // namespace

ImageSurface image_surface(const Model& model) {
  ImageSurface surface;
  if (!std::ranges::all_of(model.nodes, &ActiveNodeModel::moves_mean)) return surface;
  const auto triangles = touchable(model, surface);
  if (std::max(triangles.size(), model.nodes.size() + model.linear_points.size()) >= image::none)
    throw input_error("the surface is too large for an image",
                      std::to_string(triangles.size()) + " triangles; an image holds 65534",
                      "probe a smaller part of the body, or use a coarser mesh");
  surface.triangle = with_neighbours(triangles);
  find_gradients(model, surface);
  return surface;
}

}  // namespace phynness
