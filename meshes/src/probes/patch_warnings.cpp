#include <algorithm>
#include <cmath>
#include <phynness/formats/printable.hpp>
#include <phynness/meshes/patch_warnings.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/meshes/tool_weights.hpp>

#include "probes/select_nodes.hpp"

namespace phynness {
namespace {

/// Three digits, rounded down or up so that the recommended value is sufficient.
enum class Round { down, up, nearest };
std::string three_digits(double value, Round round = Round::nearest) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  const double units = value / unit;
  const double rounded = round == Round::down ? std::floor(units) : round == Round::up ? std::ceil(units) : units;
  return number_text(rounded * unit, std::chars_format::general, 3);
}

/// Tetrahedra of a file have a size only with remesh = true.
const char* also_remesh(const MeshSpec& mesh) {
  return mesh.shape == Shape::none && !mesh.remesh ? " (of a file of tetrahedra: and remesh = true)" : "";
}

/// The key that reduces the edge length by this factor. Meshers meet a size within a tenth.
std::string finer_mesh(const MeshSpec& mesh, double exact_factor, double mean_edge_m) {
  const double factor = 0.9 * exact_factor;
  const bool of_shape = mesh.shape != Shape::none;  // The edges of a file need not be those of its keys.
  if (mesh.target_nodes && of_shape && mesh.thickness_m == 0)
    return "target_nodes = " + three_digits(*mesh.target_nodes / (factor * factor * factor), Round::up);
  if (mesh.thickness_m > 0 && !of_shape)
    return "a mesh with edges of " + three_digits(mean_edge_m * factor, Round::down) + " m";
  const double size_m = mesh.target_size_m && of_shape ? *mesh.target_size_m : mean_edge_m;
  return "target_size_m = " + three_digits(size_m * factor, Round::down) +
         (mesh.target_nodes ? " in place of target_nodes" : "") + also_remesh(mesh);
}

std::string warn_of_edges(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  const double radius = scene.probe.tool_radius_m;
  auto edges = surface_edges_at(sets.active, mesh);
  if (edges.empty()) return "";
  std::sort(edges.begin(), edges.end());
  const auto n_short = std::upper_bound(edges.begin(), edges.end(), radius / fewest_edges_of_a_patch) - edges.begin();
  const auto too_long = static_cast<std::ptrdiff_t>(edges.size()) - n_short;
  // A few long edges are no reason for a new mesh.
  if (10 * static_cast<std::size_t>(too_long) <= edges.size()) return "";
  const double long_edge = edges[(9 * edges.size()) / 10];
  double mean = 0;
  for (const double edge : edges) mean += edge / static_cast<double>(edges.size());
  const double wanted_radius = fewest_edges_of_a_patch * long_edge;
  return scene.probe.where.str() + ": the patch is not resolved at " + std::to_string(too_long) + " of " +
         std::to_string(edges.size()) + " active nodes: its radius, tool_radius_m = " + three_digits(radius) +
         ", is less than two edges of the surface there (edges are " + three_digits(mean) + " m in the mean, up to " +
         three_digits(edges.back()) +
         " m), so that the force depends on the mesh; tool_radius_m = " + three_digits(wanted_radius, Round::up) +
         " is sufficient, or " + finer_mesh(scene.mesh, radius / wanted_radius, mean);
}

/// A patch loses the fixed nodes under it, so that the mean that it moves is that of another place. A shift of the
/// middle below this share of the radius is no more than meshes of two edges to the radius leave open.
constexpr double largest_shift = 0.1;

std::string warn_of_fixed(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  const double radius = scene.probe.tool_radius_m;
  const auto middle_of = [&](const TouchedNodes& touched) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    double weights = 0;
    for (std::size_t i = 0; i < touched.nodes.size(); ++i) {
      sum += touched.weights[i] * mesh.nodes.row(touched.nodes[i]);
      weights += touched.weights[i];
    }
    return Eigen::RowVector3d(sum / weights);
  };
  const auto is_beside_fixed = [&](std::int32_t node) {
    return std::any_of(sets.fixed.begin(), sets.fixed.end(), [&](std::int32_t fixed) {
      return (mesh.nodes.row(fixed) - mesh.nodes.row(node)).squaredNorm() < radius * radius;
    });
  };
  SurfaceTools tools(mesh.nodes, mesh.surface);
  double largest = 0;
  std::int32_t where = -1;
  int n = 0;
  for (const auto node : sets.active) {
    if (!is_beside_fixed(node)) continue;
    const auto touched = [&](std::span<const std::int32_t> fixed) {
      return middle_of(tools.touched_nodes(fixed, at_node(node), radius));
    };
    const double shift = (touched(sets.fixed) - touched({})).norm() / radius;
    n += shift > largest_shift;
    if (shift > largest) largest = shift, where = node;
  }
  if (n == 0) return "";
  return scene.probe.where.str() + ": fixed nodes take a part of the patch at " + std::to_string(n) + " of " +
         std::to_string(sets.active.size()) + " active nodes; what remains has its middle up to " +
         three_digits(largest * radius) + " m beside the node (" + three_digits(largest) + " of the radius, at node " +
         std::to_string(where) + "), and the force is that of this part; " +
         (spreads(scene.active)
              ? "without these nodes: give the selection with spacing or count from_fixed_m = " + three_digits(radius)
              : "without these nodes: active = { difference = [SELECTION, { near = { to = \"fixed\", distance_m = " +
                    three_digits(radius) + " } }] }, where SELECTION is that of now");
}

/// Spread by the radius of the tool, spacing = "auto".
bool is_automatic(const Selector& s) { return s.kind == SelectorKind::spread && !(s.length_m > 0) && s.count == 0; }
bool holds_automatic(const Selection& selection) {
  return std::ranges::any_of(
      selection, [](const Selector& s) { return is_automatic(s) || std::ranges::any_of(s.of, holds_automatic); });
}

/// As many points as a larger organ has with spacing = "auto": of fewer, leaving some out saves little.
constexpr std::ptrdiff_t fewest_worth_a_choice = 50;

/// Spread points between which a tool is not answered.
std::string warn_of_gaps(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  const std::string place = scene.active_where.str() + ": ";
  const auto n_points = std::to_string(sets.active.size()) + (sets.active.size() == 1 ? " point" : " points");
  if (scene.probe.kind == ProbeKind::node)
    return place + "node probes are answered only at the " + n_points +
           "; a round tool, kind = \"patch\" with tool_radius_m, is answered between them, too";
  const double radius = scene.probe.tool_radius_m;
  const auto made = probe_coordinates(mesh.nodes, mesh.surface, sets.active, sets.fixed, radius);
  const auto n = made.triangles.rows(), all = n + std::ssize(made.too_long);
  if (n > 0 && n == all) return "";
  const bool has_triangles_of_mesh = std::ranges::any_of(mesh.surface.rowwise(), [&](const auto& corners) {
    return std::ranges::all_of(corners, [&](auto i) { return std::ranges::binary_search(sets.active, i); });
  });
  return place +
         (n == 0
              ? "no triangle between the " + n_points
              : std::to_string(all - n) + " of " + std::to_string(all) +
                    " triangles between the points, such as at node " + std::to_string(made.too_long.front()) + ",") +
         (n == 0 ? " has edges of at most the radius" : " have edges longer than the radius") +
         ", tool_radius_m = " + three_digits(radius) + ", so that " +
         (n > 0                   ? "in these"
          : has_triangles_of_mesh ? "between them, except in triangles of the mesh, which have larger errors,"
                                  : "between them") +
         (scene.probe.elsewhere == Elsewhere::linear ? " the tool is answered as on the body at rest, with a warning"
                                                     : " the tool is not answered") +
         (holds_automatic(scene.active)
              ? std::string("; give a finer mesh, such as a smaller target_size_m") + also_remesh(scene.mesh) +
                    ", or a part without nodes far from the others"
              : "; spacing = \"auto\" covers the part if most edges of the mesh are shorter than the radius");
}

}  // namespace

std::vector<double> surface_edges_at(const std::vector<std::int32_t>& nodes, const Mesh& mesh) {
  std::vector<double> sum(static_cast<std::size_t>(mesh.n_nodes()), 0), n(sum);
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto a = mesh.surface(t, k), b = mesh.surface(t, (k + 1) % 3);
      const double length = (mesh.nodes.row(a) - mesh.nodes.row(b)).norm();
      for (const auto i : {a, b}) sum[static_cast<std::size_t>(i)] += length, n[static_cast<std::size_t>(i)] += 1;
    }
  std::vector<double> means;
  for (const auto node : nodes)
    if (const auto i = static_cast<std::size_t>(node); n[i] > 0) means.push_back(sum[i] / n[i]);
  return means;
}

std::string choice_note(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  meshes::SelectableBody body(mesh);
  body.fixed = sets.fixed;
  body.tool_radius_m = scene.probe.tool_radius_m;
  for (const auto& s : scene.active) {
    if (s.kind != SelectorKind::spread || s.count > 0) continue;
    const auto part = meshes::nodes_to_spread_over(s, body, {"active nodes", ""});
    const auto n = std::ranges::count_if(part, [&](auto i) { return std::ranges::binary_search(sets.active, i); });
    const bool automatic = is_automatic(s);
    if (automatic && n < fewest_worth_a_choice) continue;
    if (static_cast<double>(n) < (automatic ? 0.8 : 1.0) * static_cast<double>(part.size())) continue;
    const std::string nodes = std::to_string(n) + " of the " + std::to_string(part.size()) + " nodes of the part";
    return s.where.str() + ": " +
           (automatic ? "spacing = \"auto\" chose " + three_digits(1e3 * body.tool_radius_m / 3) +
                            " mm between points, a third of the radius of the tool; most edges of the mesh are not "
                            "shorter, so that " +
                            nodes +
                            " are probed; phynness plan tells the cost, and a smaller part in "
                            "`within` reduces it"
                      : "spacing_m = " + number_text(s.length_m) + " is shorter than the edges of the mesh, so that " +
                            nodes + " are probed; a larger spacing, or spacing = \"auto\", reduces the cost");
  }
  return "";
}

std::vector<std::string> patch_warnings(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  std::vector<std::string> warnings;
  const auto add = [&](std::string text) {
    if (!text.empty()) warnings.push_back(std::move(text));
  };
  if (spreads(scene.active)) add(warn_of_gaps(scene, mesh, sets));
  if (scene.probe.kind == ProbeKind::patch)
    for (auto* const warn : {warn_of_edges, warn_of_fixed}) add(warn(scene, mesh, sets));
  return warnings;
}

}  // namespace phynness
