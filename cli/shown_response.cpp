#include "shown_response.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/tool.hpp>

namespace phynness::cli {
namespace {

std::size_t active_index(const DatabaseHeader& header, std::int32_t node) {
  const auto& active = header.sets.active;
  const auto at = std::lower_bound(active.begin(), active.end(), node);
  if (at != active.end() && *at == node) return static_cast<std::size_t>(at - active.begin());
  throw input_error("the database has no responses of this node", fmt::format("--node {}", node),
                    fmt::format("give one of the {} active nodes, {} to {}; phynness info lists them", active.size(),
                                active.front(), active.back()));
}

void check_increment(const DatabaseHeader& header, const Ray& ray, std::optional<int> increment) {
  const auto n = static_cast<int>(header.magnitudes_m.size());
  if (increment && (*increment < 1 || *increment > n))
    throw input_error("there is no such increment", fmt::format("--increment {}", *increment),
                      fmt::format("give a number from 1 to {}", n));
  const auto wanted = [&](int i) { return !increment || *increment == i + 1; };
  for (int i = 0; i < n; ++i)
    if (wanted(i) && ray.status[static_cast<std::size_t>(i)] == Status::converged) return;
  const auto status = ray.status[static_cast<std::size_t>(increment.value_or(1) - 1)];
  throw input_error(increment ? "this increment did not converge" : "no increment of this ray converged",
                    fmt::format("{}: {}", name(status), meaning(status)),
                    "choose another --increment or --direction; phynness info counts the outcomes");
}

TouchedNodes tool_nodes(const DatabaseHeader& header, std::int32_t node) {
  return touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, node, stored_scene(header).probe);
}

/// Rows of `all` whose nodes are all known, with node numbers replaced by point numbers.
template <class Faces>
Cells between_known(const Faces& all, const std::vector<std::int32_t>& point_of) {
  Cells cells(all.rows(), all.cols());
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    bool known = true;
    for (Eigen::Index k = 0; k < all.cols(); ++k) {
      cells(n, k) = point_of[static_cast<std::size_t>(all(i, k))];
      known = known && cells(n, k) >= 0;
    }
    if (known) ++n;
  }
  cells.conservativeResize(n, Eigen::NoChange);
  return cells;
}

Cells shown_cells(const Mesh& mesh, const std::vector<std::int32_t>& point_of, std::size_t n_known,
                  std::vector<std::string>& notes) {
  const auto n_nodes = static_cast<std::size_t>(mesh.n_nodes());
  if (n_known == n_nodes) return between_known(mesh.cells, point_of);
  const auto counted = fmt::format("displacements of {} of {} nodes are known", n_known, n_nodes);
  Cells triangles = between_known(mesh.surface, point_of);
  if (triangles.rows() > 0) {
    notes.push_back(
        fmt::format("{}: the file has {} of {} surface triangles and no tetrahedra (with nodes.output = "
                    "\"all\" all displacements are stored)",
                    counted, triangles.rows(), mesh.surface.rows()));
    return triangles;
  }
  notes.push_back(counted + ", but not the three corners of any surface triangle: the file has points only");
  Cells vertices(static_cast<Eigen::Index>(n_known), 1);
  for (Eigen::Index i = 0; i < vertices.rows(); ++i) vertices(i, 0) = static_cast<std::int32_t>(i);
  return vertices;
}

}  // namespace

ShownResponse shown_response(const Database& database, std::int32_t node, int direction, std::optional<int> increment) {
  const auto& header = database.header();
  const auto active = active_index(header, node);
  if (direction < 0 || direction >= static_cast<int>(header.directions.size()))
    throw input_error("there is no such direction", fmt::format("--direction {}", direction),
                      fmt::format("give a number from 0 to {}; formats/database.md describes their order",
                                  header.directions.size() - 1));
  const auto rays = database.rays(static_cast<std::int32_t>(active));
  const Ray& ray = rays[static_cast<std::size_t>(direction)];
  check_increment(header, ray, increment);

  const auto tool = tool_nodes(header, node);
  constexpr std::int32_t unknown = -1;
  std::vector<std::int32_t> point_of(static_cast<std::size_t>(header.mesh.n_nodes()), unknown);
  for (const auto* set : {&header.sets.output, &header.sets.fixed, &tool.nodes})
    for (const auto n : *set) point_of[static_cast<std::size_t>(n)] = 0;
  ShownResponse shown;
  auto& grid = shown.grid;
  for (std::int32_t n = 0; n < header.mesh.n_nodes(); ++n) {
    auto& point = point_of[static_cast<std::size_t>(n)];
    if (point == unknown) continue;
    point = static_cast<std::int32_t>(grid.node_numbers.size());
    grid.node_numbers.push_back(n);
  }
  const auto n_points = static_cast<Eigen::Index>(grid.node_numbers.size());
  grid.points.resize(n_points, 3);
  for (Eigen::Index i = 0; i < n_points; ++i)
    grid.points.row(i) = header.mesh.nodes.row(grid.node_numbers[static_cast<std::size_t>(i)]);
  grid.cells = shown_cells(header.mesh, point_of, grid.node_numbers.size(), shown.notes);

  Eigen::MatrixXd weight = Eigen::MatrixXd::Zero(n_points, 1);
  for (std::size_t i = 0; i < tool.nodes.size(); ++i)
    weight(point_of[static_cast<std::size_t>(tool.nodes[i])], 0) = tool.weights[i];
  const auto& output = header.sets.output;
  const Eigen::Map<const Eigen::RowVector3d> unit(header.directions[static_cast<std::size_t>(direction)].data());
  for (std::size_t i = 0; i < header.magnitudes_m.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    if (increment && *increment != number) continue;
    if (ray.status[i] != Status::converged) {
      shown.notes.push_back(
          fmt::format("increment {} is left out: {}: {}", number, name(ray.status[i]), meaning(ray.status[i])));
      continue;
    }
    const double depth_m = header.magnitudes_m[i];
    Eigen::MatrixXd u = weight * (depth_m * unit), force = Eigen::MatrixXd::Zero(n_points, 3);
    for (std::size_t j = 0; j < output.size(); ++j)
      u.row(point_of[static_cast<std::size_t>(output[j])]) =
          Eigen::Map<const Eigen::RowVector3d>(&ray.displacement[3 * (i * output.size() + j)]);
    force.row(point_of[static_cast<std::size_t>(node)]) = Eigen::Map<const Eigen::RowVector3d>(&ray.force[3 * i]);
    shown.states.push_back(
        {depth_m, {{"displacement", std::move(u)}, {"force", std::move(force)}, {"prescribed", weight}}});
    for (std::size_t f = 0; f < header.fields.size(); ++f) {
      Eigen::MatrixXd values = Eigen::MatrixXd::Zero(n_points, 1);
      for (std::size_t j = 0; j < output.size(); ++j)
        values(point_of[static_cast<std::size_t>(output[j])], 0) = ray.fields[f][i * output.size() + j];
      shown.states.back().fields.push_back({column(header.fields[f]), std::move(values)});
    }
    shown.increments.push_back(number);
  }
  if (const auto left = grid.node_numbers.size() - output.size(); !header.fields.empty() && left > 0)
    shown.notes.push_back(
        fmt::format("fields are stored at output nodes only; the file has 0 at {} other points", left));
  return shown;
}

}  // namespace phynness::cli
