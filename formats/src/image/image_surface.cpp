#include "image_surface.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/schema/surface_gradient.hpp>

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

/// Halves of the gradients of equation (x), as the parts of weights that neighbours take: mean_at in
/// runtime/src/tools/round_tool.cpp.
void find_gradients(const Model& model, ImageSurface& surface) {
  const auto n_active = static_cast<std::int32_t>(model.nodes.size());
  const std::size_t n_points = model.nodes.size() + model.linear_points.size();
  const bool spread = model.probe_triangles.rows() > 0;
  const Triangles& inner = spread ? model.probe_triangles : model.surface;
  const auto n_inner = static_cast<std::int32_t>(inner.rows());
  const auto corner_of = [&](std::int32_t t, int k) {
    if (t < n_inner) return spread ? inner(t, k) : active_position(model, inner(t, k));
    const std::int32_t point = model.outer_triangles(t - n_inner, k);
    return point < n_active ? -1 : point;
  };
  const auto point_of = [&](std::int32_t i) {
    const auto at = static_cast<std::size_t>(i);
    return i < n_active ? model.nodes[at].point.data() : model.linear_points[at - model.nodes.size()].point.data();
  };
  std::vector<schema::NearPoints> first(n_points);
  std::vector<schema::Neighbours> neighbours(n_points);
  schema::find_neighbours(static_cast<std::int32_t>(n_points), point_of,
                          n_inner + static_cast<std::int32_t>(model.outer_triangles.rows()), corner_of, first.data(),
                          neighbours.data());
  std::vector<Eigen::RowVector3d> slopes;
  surface.begin.push_back(0);
  for (const auto& near : neighbours) {
    for (std::int32_t i = 0; i < near.n; ++i) {
      surface.neighbour.push_back(static_cast<std::uint16_t>(near.point[i]));
      slopes.emplace_back(0.5 * Eigen::RowVector3d::Map(near.slope[i]));
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
