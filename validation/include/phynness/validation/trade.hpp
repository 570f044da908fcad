// What accuracy costs: the elements and meshes of a scene, each with its distance to a finer solution and its time.
#pragma once

#include <phynness/validation/discretization.hpp>

namespace phynness {

/// One element on one mesh.
struct TradeRow {
  Scene scene;                         ///< with this element and this size of the mesh
  std::optional<DatabaseHeader> body;  ///< empty if there is no such body
  double unknowns = 0;
  std::string left_out;      ///< reason why it was not compared; empty: it was
  std::int64_t probes = 0;   ///< that both this row and the reference solve
  double mean = 0, p95 = 0;  ///< relative error of the force there
  double ray_s = 0;          ///< CPU time of a ray with the preparation of its place, mean
  std::int64_t rays = 0;     ///< that a database of this row would solve
  bool is_scene = false;     ///< as the scene has it
  bool is_reference = false;
  bool on_front = false;  ///< no other row is better in error and time

  double core_hours() const { return ray_s * static_cast<double>(rays) / 3600; }
  static void describe(const auto& row, auto&& see) {
    const auto known = [&](double value) { return row.probes > 0 ? value : undefined; };
    see("element", name(row.scene.solver.element));
    see("nodes", row.body ? row.body->mesh.n_nodes() : 0);
    see("target_nodes", row.scene.mesh.target_nodes);
    see("target_size_m", row.scene.mesh.target_size_m);
    see("left_out", row.left_out.empty() ? std::nullopt : std::optional(row.left_out));
    see("probes", row.probes);
    see("mean", known(row.mean));
    see("p95", known(row.p95));
    see("ray_seconds", row.ray_s > 0 ? row.ray_s : undefined);
    see("core_hours", row.ray_s > 0 ? row.core_hours() : undefined);
    see("is_scene", row.is_scene);
    see("is_reference", row.is_reference);
    see("on_front", row.on_front);
  }
};

struct TradeReport {
  std::vector<TradeRow> rows;  ///< by mesh, coarse first, then in the order of elements()
  double tool_radius_m = 0;
  std::int64_t probes = 0;
  double seconds = 0;
  bool interrupted = false;
  PHYNNESS_FIGURES(tool_radius_m, probes, rows, seconds, interrupted)
};

/// Compares all elements that the scene can have, on its mesh and, where phynness makes it, on meshes of half and twice
/// as many nodes, with Taylor-Hood elements (P2 if lambda is not positive) on the finest of them. All touch the body at
/// the same points of space, with round tools of the same radius. Must run as one process.
/// @param options  its `reference` is not used
/// @throws Error (input) if there is one body only, as of shells, and if the reference needs more than
/// options.seconds, before it is solved
TradeReport compare_discretizations(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                    const DiscretizationOptions& options, const OnProgress& progress = {},
                                    const ShouldStop& stop = {});

}  // namespace phynness
