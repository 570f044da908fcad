// Discretization error of a scene: a few probes are compared with a finer solution. A second function compares the
// error and the time of all elements and mesh sizes.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/described.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/progress.hpp>
#include <phynness/formats/scene.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace phynness {

/// The scene and the variants with which it is compared.
enum class Variant : std::size_t { scene, taylor_hood, half_size };
const char* name(Variant);  ///< from reference_names
std::optional<Variant> variant_named(std::string_view name);

struct VariantForces {
  std::vector<Status> status;  ///< per depth; empty if the variant was not solved
  std::vector<Vec3> force_N;   ///< per depth; valid if it converged
  bool converged(std::size_t depth) const { return depth < status.size() && status[depth] == Status::converged; }
  static void describe(const auto& forces, auto&& see) {
    std::vector<const char*> names;
    std::vector<double> sizes;
    for (std::size_t i = 0; i < forces.status.size(); ++i) {
      names.push_back(name(forces.status[i]));
      sizes.push_back(forces.converged(i) ? to_eigen(forces.force_N[i]).norm() : undefined);
    }
    see("status", names);
    see("force", sizes);
  }
};

/// The stiffness of a round tool at rest on successively finer bodies. Each distance is the Frobenius norm of the
/// difference over that of the finer stiffness; it is undefined if the bodies were not compared.
struct PlaceAtRest {
  std::int32_t node = 0;
  bool near_fixed = false;
  double element = undefined;  ///< from the scene's element to Taylor-Hood on the same mesh
  double cells = undefined;    ///< from there to cells of half the size with the same surface
  double shape =
      undefined;  ///< from there to a mesh of about this size on the surface of the scene; 0 if it is the mesh's
  double all = undefined;  ///< from the scene to the finest of these bodies
  /// Stiffness of the finest body times the inverse stiffness of the reference.
  Eigen::Matrix3d finest_over_reference = Eigen::Matrix3d::Identity();
  PHYNNESS_FIGURES(node, near_fixed, element, cells, shape, all)
};

struct ComparisonAtRest {
  std::vector<PlaceAtRest> places;
  std::string skipped_reason;  ///< what was not compared, and why
  double sufficient_s = 0;     ///< estimated time limit of a check that also compares this; 0: time is not the reason
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(places);
    see("left_out", result.skipped_reason.empty() ? std::nullopt : std::optional(result.skipped_reason));
  }
};

struct CheckedProbe {
  std::int32_t node = 0;
  bool near_fixed = false;  ///< a fixed node is nearer than the radius of the tool
  Vec3 direction{};
  double inward = 0;  ///< cosine between the direction and the inward normal
  VariantForces own, finer;
  /// See PlaceAtRest.
  Eigen::Matrix3d finest_over_reference = Eigen::Matrix3d::Identity();
  /// The force of the finer solution, corrected by the change of the stiffness at rest on the finest body.
  Eigen::Vector3d finest_N(std::size_t depth) const { return finest_over_reference * to_eigen(finer.force_N[depth]); }
  /// Magnitude of the scene's force over that of the finest force; empty unless both converged.
  std::optional<double> ratio(std::size_t depth) const;
  /// The last of the depths with a ratio.
  std::optional<std::size_t> deepest() const;
  /// Relative error of the scene's force at the largest displacement that both solve, as in FinerDistance.
  std::optional<double> error() const { return error_of(own); }
  /// The same error for `own` or `finer`.
  std::optional<double> error_of(const VariantForces& forces) const;
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(node, near_fixed, direction, inward);
    see("scene", result.own);
    see("finer", result.finer);
    std::vector<double> sizes;
    for (std::size_t i = 0; i < result.finer.status.size(); ++i)
      sizes.push_back(result.finer.converged(i) ? result.finest_N(i).norm() : undefined);
    see("finest_force", sizes);
  }
};

/// Statistics of one comparison at one depth, over the probes with a ratio.
struct RatioStatistics {
  double depth_m = 0, median = 0, min = 0, max = 0;
  std::int64_t n = 0;
  static void describe(const auto& result, auto&& see) {
    const auto known = [&](double value) { return result.n > 0 ? value : undefined; };
    see("depth_m", result.depth_m);
    see("median", known(result.median));
    see("min", known(result.min));
    see("max", known(result.max));
    see("n", result.n);
  }
};

struct DiscretizationReport {
  Variant reference = Variant::taylor_hood;
  std::int32_t nodes = 0;  ///< number of nodes of the reference's mesh
  double tool_radius_m = 0;
  bool patch_for_node = false;  ///< patches of tool_radius_m replace the nodes that the scene displaces
  double mean_edge_m = 0;       ///< mean over all edges of the mesh
  double tool_edges = 0;        ///< tool_radius_m in mean surface edges at the active nodes (surface_edges_at)
  std::vector<double> depth_m;  ///< ascending; the last one is the largest displacement of the scene
  std::vector<CheckedProbe> probes;
  ComparisonAtRest at_rest;
  double near_share = 0;       ///< share of the touched surface that is nearer than the tool's radius to a fixed node
  double unknowns_factor = 0;  ///< unknowns of the reference over those of the scene
  std::int64_t left_out = 0;   ///< probes that exceed the time limit
  double seconds = 0;
  double sufficient_s = 0;  ///< estimated time of all probes
  bool interrupted = false;

  /// Estimated time of all probes or, if that is longer, of all comparisons at rest.
  double all_sufficient_s() const { return std::max(sufficient_s, at_rest.sufficient_s); }
  RatioStatistics ratios(std::size_t depth) const;
  FinerDistance distance(const Scene& scene) const;
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(tool_radius_m, tool_edges, patch_for_node, mean_edge_m, depth_m);
    see("reference", name(result.reference));
    std::vector<RatioStatistics> all;
    for (std::size_t i = 0; i < result.depth_m.size(); ++i) all.push_back(result.ratios(i));
    see("ratios", all);
    PHYNNESS_SEE(nodes, near_share, probes, at_rest, left_out, interrupted, seconds);
    see("sufficient_seconds", result.all_sufficient_s());
  }
};

/// The available memory according to /proc/meminfo; infinite on systems without this file.
double available_memory_bytes();

struct DiscretizationOptions {
  int probes = 12;                           ///< upper limit; the check ends earlier when is_known()
  Variant reference = Variant::taylor_hood;  ///< reference of a check
  /// A probe is not started if its predicted end is later. A running probe is then abandoned at its next iteration.
  double seconds = 60;
  /// Time in seconds, from any origin.
  std::function<double()> clock = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  std::function<double()> available_bytes = available_memory_bytes;
};

/// The default finer solution: Taylor-Hood on the same mesh, which does not lock, or cells of half the size if the
/// scene has no such variant.
Variant finer_reference(const Scene& scene);

/// @throws Error (input) if the scene has no such variant
void require_variant(const Scene& scene, Variant v);

struct VariantBody {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
};
/// The body of a variant. Existing nodes of the mesh keep their numbers.
VariantBody variant_body(Variant v, VariantBody body);
/// The number of unknowns of a variant, without making its mesh.
double variant_unknowns(Variant v, Element element, const Mesh& mesh);

/// About the memory of all comparisons of a check of a solid; measured: 0.61 GB for es-p1-p1 on 320 nodes, 0.98 and
/// 4.8 GB for taylor-hood on 320 and 1,097.
double check_memory_bytes(const Scene& scene, const Mesh& mesh);

/// Time limit [s] of the check in `phynness run`: a quarter of the time of the database, and at least 30 s, in which a
/// body of 400 nodes is also compared at rest with its surface's own shape.
/// @param solve_s  CPU time of the solves of the database
inline double check_limit_s(double solve_s, int ranks) { return std::max(60.0, solve_s / ranks / 4); }

/// Radius of the patch that replaces a node in a check. The force at a node depends on the element even without
/// locking: P1 moves a node, P2 also the midpoints of its edges (docs/theory.md, What a probe is).
/// @param edge_m  mean length of surface edges at the active nodes
double patch_radius_for_node(double edge_m, double max_displacement_m);

/// The indices of the active node and the direction of a ray.
struct CheckedRay {
  std::int32_t active = 0, direction = 0;
  bool near_fixed = false;
};
/// Rays in an order in which every prefix represents the surface of the active nodes. The nodes follow the golden-ratio
/// sequence over the cumulative area, first away from fixed nodes and then near them. The directions alternate between
/// the most inward, the most tangential and the most outward requested direction.
struct CheckedRays {
  std::vector<CheckedRay> rays;
  double near_share = 0;  ///< share of the area near fixed nodes
};
/// @param radius_m  distance from a fixed node below which a node is near it
CheckedRays choose_checked_rays(const DatabaseHeader& header, const std::vector<char>& requested, double radius_m,
                                std::size_t wanted);

/// The nodes at which a check may place tools: the active nodes, and the nodes between them that a model covers.
NodeList answered_nodes(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// Whether the mean error is known well enough: there are at least four probes, at least two in each part (near and far
/// from fixed nodes) with a sixth of the area, and the standard error is at most a third of the mean, or 1 %.
bool is_known(const std::vector<CheckedProbe>& probes, double near_share);

/// Solves each probe with the scene and the reference within the time limit. Must run as one process.
/// @param progress  receives the numbers of finished and of planned rays
/// @throws Error if the scene has no such reference or cannot be solved
DiscretizationReport check_discretization(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                          const DiscretizationOptions& options, const OnProgress& progress = {},
                                          const ShouldStop& stop = {});

/// One element on one mesh.
struct TradeRow {
  Scene scene;                         ///< has the element and the mesh size of the row
  std::optional<DatabaseHeader> body;  ///< empty if the mesh could not be made
  double unknowns = 0;
  std::string left_out;      ///< why the row was not compared; empty if it was
  std::int64_t probes = 0;   ///< number of probes that both this row and the reference solve
  double mean = 0, p95 = 0;  ///< relative error of their forces
  double ray_s = 0;          ///< mean CPU time of a ray, with the preparation of its node
  std::int64_t rays = 0;     ///< number of rays of a database of this row
  bool is_scene = false;     ///< the scene has this element and this mesh
  bool is_reference = false;
  bool on_front = false;  ///< Pareto front: no other row is better in error and time

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

/// Compares all possible elements, on the scene's mesh and on meshes of half and twice as many nodes if phynness
/// generates the mesh. The reference has Taylor-Hood elements (P2 if lambda is not positive) on the finest mesh. The
/// tools are round and touch the same points in space with the same radius. Must run as one process.
/// @param options  `reference` is not used
/// @throws Error (input) if there is only one row, as for a shell, or if the reference is predicted to need more than
/// options.seconds
TradeReport compare_discretizations(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                    const DiscretizationOptions& options, const OnProgress& progress = {},
                                    const ShouldStop& stop = {});

/// Whether only the scene itself was compared, beside which there is nothing to choose.
bool is_alone(const TradeReport& report);

/// Of the rows within the limit the one whose database needs the least time.
/// @param error  largest mean error, as a fraction. @return null: there is none, or the scene is_alone()
const TradeRow* chosen_row(const TradeReport& report, double error);

}  // namespace phynness
