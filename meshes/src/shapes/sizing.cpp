#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <optional>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "read/file_mesh.hpp"

namespace phynness::meshes {
namespace {

constexpr double most_nodes = 1e6;
constexpr int most_meshings = 10;
constexpr double least_step = 2e-4;  // of the logarithm of the edge length
constexpr double good_enough = 0.005, far_off = 0.05;
constexpr double good_enough_big = 0.02;  // large meshes take long and need no exact number of nodes
constexpr int big = 10000;

/// Expected number of nodes of a mesh of this edge length, with an error of some tens of percent.
double expected_nodes(const Extent& extent, double edge_m) {
  // Six equilateral triangles meet at a node. A Delaunay mesh has about 5.5 tetrahedra per interior node, and there are
  // no interior nodes in the layer next to the surface.
  const double surface = extent.area_m2 / (std::sqrt(3.0) / 2 * edge_m * edge_m);
  const double interior =
      std::max(0.0, extent.volume_m3 - 0.5 * edge_m * extent.area_m2) / (0.65 * std::pow(edge_m, 3));
  return surface + interior;
}

double edge_for(const Extent& extent, double nodes) {
  double low = 1e-9 * std::max(std::cbrt(extent.volume_m3), std::sqrt(extent.area_m2));
  double high = 1e3 * std::sqrt(extent.area_m2);
  for (int i = 0; i < 100; ++i) {
    const double middle = std::sqrt(low * high);
    (expected_nodes(extent, middle) > nodes ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

void require_affordable(const Extent& extent, double edge_m, const std::string& place) {
  const double n = expected_nodes(extent, edge_m);
  if (n <= most_nodes) return;
  std::ostringstream value, remedy;
  value << "edge length " << edge_m << " m gives about " << n << " nodes in " << extent.volume_m3 << " m^3";
  remedy << "use at most " << most_nodes << " nodes, which means an edge length above " << edge_for(extent, most_nodes)
         << " m, or check mesh.scale_to_m";
  throw input_error(place + ": the mesh would be too large", value.str(), remedy.str());
}

void require_short(const Extent& extent, double edge_m, bool is_file, const std::string& place) {
  if (expected_nodes(extent, edge_m) >= 1) return;
  std::ostringstream value, remedy;
  value << edge_m << " m, where the surface of the body has " << extent.area_m2 << " m^2";
  constexpr double proposed_nodes = 1000;
  remedy << std::setprecision(2) << "give a smaller mesh.target_size_m in metres, such as "
         << edge_for(extent, proposed_nodes) << (is_file ? ", or check mesh.scale_to_m" : "");
  throw input_error(place + ": mesh.target_size_m is too large for the body", value.str(), remedy.str());
}

MeshResult meet_node_target(int target, const Extent& extent, const std::string& place,
                            const std::function<MeshResult(double edge_m)>& mesh_at) {
  std::optional<MeshResult> best;
  std::optional<Error> last_error;
  double best_edge = 0, log_edge = std::log(edge_for(extent, target));
  double previous_edge = 0, previous_nodes = 0, slope = -2.5;
  // Sizes that are known to give too many and too few nodes; sizes outside of this interval are not tried again.
  double too_fine = -std::numeric_limits<double>::infinity(), too_coarse = -too_fine;
  int meshings = 0;
  const auto miss = [target](const MeshResult& r) { return std::abs(r.mesh.n_nodes() - target); };
  while (meshings < most_meshings) {
    ++meshings;
    try {
      MeshResult result = mesh_at(std::exp(log_edge));
      const std::int32_t result_nodes = result.mesh.n_nodes();
      const double log_nodes = std::log(static_cast<double>(result_nodes));
      // Two meshes of nearly the same size do not determine the slope.
      if (previous_nodes > 0 && std::abs(log_edge - previous_edge) > 0.01)
        slope = std::clamp((log_nodes - previous_nodes) / (log_edge - previous_edge), -4.0, -1.5);
      previous_edge = log_edge;
      previous_nodes = log_nodes;
      if (!best || miss(result) < miss(*best)) best = std::move(result), best_edge = std::exp(log_edge);
      if (miss(*best) <= (target > big ? good_enough_big : good_enough) * target) break;
      (result_nodes > target ? too_fine : too_coarse) = log_edge;
      log_edge += (std::log(static_cast<double>(target)) - log_nodes) / slope;
      if (too_coarse - too_fine < least_step) break;  // the number of nodes jumps across the target
      if (std::isfinite(too_coarse - too_fine) && (log_edge <= too_fine || log_edge >= too_coarse))
        log_edge = (too_fine + too_coarse) / 2;
    } catch (const Error& error) {
      if (error.kind() == Error::Kind::input) throw;
      last_error = error;
      log_edge += std::log(slightly_finer);
    }
  }
  if (!best) throw *last_error;
  std::ostringstream note;
  note << "wanted " << target << " nodes, got " << best->mesh.n_nodes() << " with edge length " << best_edge << " m ("
       << meshings << (meshings == 1 ? " meshing)" : " meshings)");
  best->notes.push_back(note.str());
  if (miss(*best) > far_off * target)
    best->warnings.push_back(place + ": target_nodes is missed by more than 5 %: " +
                             std::to_string(best->mesh.n_nodes()) + " instead of " + std::to_string(target));
  return std::move(*best);
}

Extent extent_of_shape(const MeshSpec& s) {
  using std::numbers::pi;
  const auto& [x, y, z] = s.size_m;
  if (s.shape == Shape::block) return {x * y * z, 2 * (x * y + y * z + z * x)};
  if (s.shape == Shape::drain) return {0, 2 * pi * s.radius_m * s.length_m - pi / 4 * s.slit_length_m * s.slit_width_m};
  const double hole = s.shape == Shape::tube ? s.inner_radius_m : 0;
  return {pi * (s.radius_m * s.radius_m - hole * hole) * s.length_m,
          2 * pi * ((s.radius_m + hole) * s.length_m + s.radius_m * s.radius_m - hole * hole)};
}

}  // namespace phynness::meshes
