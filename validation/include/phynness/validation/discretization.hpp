// Effect of element and cell size on the forces of a scene: a few probes compared with a finer solution. And what
// accuracy costs: the elements and meshes of a scene, each with its distance to a finer solution and its time.
#pragma once

#include <algorithm>
#include <array>
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

/// The scene and the variants with which it is compared, as reference_names.
enum class Variant : std::size_t { scene, taylor_hood, half_size };
const char* name(Variant);  ///< of reference_names
std::optional<Variant> variant_named(std::string_view name);

struct VariantForces {
  std::vector<Status> status;  ///< per depth; empty: not solved
  std::vector<Vec3> force_N;   ///< per depth, if it converged
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

/// What finer bodies do to the stiffness of a round tool at rest. Distances are Frobenius norms of differences over
/// those of the finer one; undefined: not compared.
struct PlaceAtRest {
  std::int32_t node = 0;
  bool near_fixed = false;
  double element = undefined;  ///< of the scene's element from Taylor-Hood on the same mesh
  double cells = undefined;    ///< of these from cells of half the size, whose surface is that of the mesh
  double shape = undefined;    ///< of these from a mesh of about the same size, whose surface is that of the scene
  double all = undefined;      ///< of the scene from the finest of these bodies
  /// Stiffness of the finest one times the inverse of that of the reference.
  Eigen::Matrix3d finest_over_reference = Eigen::Matrix3d::Identity();
  PHYNNESS_FIGURES(node, near_fixed, element, cells, shape, all)
};

struct ComparisonAtRest {
  std::vector<PlaceAtRest> places;
  std::string why_not;  ///< what is left out, with the reason
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(places);
    see("left_out", result.why_not.empty() ? std::nullopt : std::optional(result.why_not));
  }
};

struct CheckedProbe {
  std::int32_t node = 0;
  bool near_fixed = false;  ///< nearer than the radius of the tool to a fixed node
  Vec3 direction{};
  double inward = 0;  ///< cosine between the direction and the inward normal
  VariantForces own, finer;
  /// As of PlaceAtRest.
  Eigen::Matrix3d finest_over_reference = Eigen::Matrix3d::Identity();
  /// The force of the finer solution, changed as finer bodies change the stiffness at rest.
  Eigen::Vector3d finest_N(std::size_t depth) const { return finest_over_reference * to_eigen(finer.force_N[depth]); }
  /// Size of the scene's force over that of the finest one; empty unless both converged.
  std::optional<double> ratio(std::size_t depth) const;
  /// As FinerDistance: the relative error of the scene's force at the largest displacement that both solve.
  std::optional<double> error() const { return error_of(own); }
  /// The same of `own` or `finer`.
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
  std::int32_t nodes = 0;  ///< of the mesh of the reference
  double tool_radius_m = 0;
  bool patch_for_node = false;  ///< the scene displaces nodes, and patches of tool_radius_m were solved instead
  double mean_edge_m = 0;       ///< of all edges of the mesh
  double tool_edges = 0;        ///< tool_radius_m in mean surface edges at the active nodes (surface_edges_at)
  std::vector<double> depth_m;  ///< ascending; the last one is the largest displacement of the scene
  std::vector<CheckedProbe> probes;
  ComparisonAtRest at_rest;
  double near_share = 0;       ///< of the answered surface: nearer than the tool's radius to a fixed node
  double unknowns_factor = 0;  ///< unknowns of the reference over those of the scene
  std::int64_t left_out = 0;   ///< probes that the time does not allow
  double seconds = 0;
  double sufficient_s = 0;  ///< about what all probes need
  bool interrupted = false;

  RatioStatistics ratios(std::size_t depth) const;
  FinerDistance distance(const Scene& scene) const;
  static void describe(const auto& result, auto&& see) {
    PHYNNESS_SEE(tool_radius_m, tool_edges, patch_for_node, mean_edge_m, depth_m);
    see("reference", name(result.reference));
    std::vector<RatioStatistics> all;
    for (std::size_t i = 0; i < result.depth_m.size(); ++i) all.push_back(result.ratios(i));
    see("ratios", all);
    PHYNNESS_SEE(nodes, near_share, probes, at_rest, left_out, interrupted, seconds);
    see("sufficient_seconds", result.sufficient_s);
  }
};

/// Memory that a process can still take, by /proc/meminfo; infinite where there is none.
double available_memory_bytes();

struct DiscretizationOptions {
  int probes = 12;                           ///< at most; the check ends earlier when is_known()
  Variant reference = Variant::taylor_hood;  ///< of a check
  /// No probe is begun whose predicted end is later, and one that is at work then is given up at its next iteration.
  double seconds = 60;
  /// Time in seconds, from any origin.
  std::function<double()> clock = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  std::function<double()> available_bytes = available_memory_bytes;
};

/// The finer solution that is named with a model: Taylor-Hood on the same mesh, which does not lock, or cells of half
/// the size where the scene has no such variant.
Variant finer_reference(const Scene& scene);

/// @throws Error (input) if the scene has no such variant
void require_variant(const Scene& scene, Variant v);

struct VariantBody {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
};
/// The body of a variant. The nodes that the mesh has keep their numbers.
VariantBody variant_body(Variant v, VariantBody body);
/// Its unknowns; it need not be made for that.
double variant_unknowns(Variant v, Element element, const Mesh& mesh);

/// Time [s] of the check in `phynness run`: a quarter of that of the database, so at most a fifth of all, but a second.
/// @param solve_s  CPU time of the solves of the database
inline double check_limit_s(double solve_s, int ranks) { return std::max(1.0, solve_s / ranks / 4); }

/// Radius of the patch that replaces a node in a check. The force at a node depends on the element even without
/// locking: P1 moves a node, P2 also the midpoints of its edges (docs/theory.md, What a probe is).
/// @param edge_m  mean length of the surface's edges at the active nodes
double patch_radius_for_node(double edge_m, double max_displacement_m);

/// A ray of a check, by the indices of an active node and a direction.
struct CheckedRay {
  std::int32_t active = 0, direction = 0;
  bool near_fixed = false;
};
/// Rays in an order of which each beginning represents the surface of the active nodes: places follow the sequence of
/// the golden ratio over the area, counted along the body and then along its part near fixed nodes. Their directions
/// are in turn the most inward, the most tangential and the most outward one that the scene requests.
struct CheckedRays {
  std::vector<CheckedRay> rays;
  double near_share = 0;  ///< of the area
};
/// @param radius_m  nodes nearer than this to a fixed node are near to it
CheckedRays choose_checked_rays(const DatabaseHeader& header, const std::vector<char>& requested, double radius_m,
                                std::size_t wanted);

/// The scene's nodes at which a check may place its tools: those that active nodes answer, also between them.
NodeList answered_nodes(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// Whether the mean error of a check is known well enough: from four places on, of which two are in each part with at
/// least a sixth of the area, when its standard error is at most a third of the mean or 1 %.
bool is_known(const std::vector<CheckedProbe>& probes, double near_share);

/// Solves each probe with the scene and the reference until the time is over. Must run as one process.
/// @param progress  finished rays and their largest possible number
/// @throws Error if the scene has no such reference or cannot be solved
DiscretizationReport check_discretization(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                          const DiscretizationOptions& options, const OnProgress& progress = {},
                                          const ShouldStop& stop = {});

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
