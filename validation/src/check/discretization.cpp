#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/patch_warnings.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <tuple>

#include "compared_scene.hpp"

namespace phynness {

const char* name(Variant v) { return reference_names[static_cast<std::size_t>(v)]; }

std::optional<Variant> variant_named(std::string_view name) {
  const auto found = std::ranges::find(reference_names, name);
  if (found == reference_names.end()) return std::nullopt;
  return static_cast<Variant>(found - reference_names.begin());
}

std::optional<double> CheckedProbe::ratio(std::size_t depth) const {
  if (!own.converged(depth) || !finer.converged(depth) || !(finest_N(depth).norm() > 0)) return {};
  return to_eigen(own.force_N[depth]).norm() / finest_N(depth).norm();
}

std::optional<std::size_t> CheckedProbe::deepest() const {
  for (std::size_t depth = own.status.size(); depth-- > 0;)
    if (ratio(depth)) return depth;
  return {};
}

std::optional<double> CheckedProbe::error_of(const VariantForces& forces) const {
  const auto depth = deepest();
  if (!depth) return {};
  return (to_eigen(forces.force_N[*depth]) - finest_N(*depth)).norm() / finest_N(*depth).norm();
}

bool is_known(const std::vector<CheckedProbe>& probes, double near_share) {
  std::vector<double> errors;
  std::size_t near = 0;
  for (const auto& probe : probes)
    if (const auto error = probe.error()) {
      errors.push_back(*error);
      near += probe.near_fixed ? 1 : 0;
    }
  const std::size_t n = errors.size();
  if (n < 4 || (near_share >= 1.0 / 6 && near < 2) || (near_share <= 5.0 / 6 && n - near < 2)) return false;
  const auto all = Eigen::Map<const Eigen::ArrayXd>(errors.data(), std::ssize(errors));
  const double standard_error = std::sqrt((all - all.mean()).square().sum() / static_cast<double>(n * (n - 1)));
  return standard_error <= std::max(all.mean() / 3, 0.01);
}

RatioStatistics DiscretizationReport::ratios(std::size_t depth) const {
  std::vector<double> all;
  for (const auto& probe : probes)
    if (const auto ratio = probe.ratio(depth)) all.push_back(*ratio);
  if (all.empty()) return {depth_m[depth]};
  std::sort(all.begin(), all.end());
  const std::size_t n = all.size();
  return {depth_m[depth], (all[(n - 1) / 2] + all[n / 2]) / 2, all.front(), all.back(), static_cast<std::int64_t>(n)};
}

FinerDistance DiscretizationReport::distance(const Scene& scene) const {
  std::vector<double> near, elsewhere, reference_errors;
  double sum_of_ratios = 0;
  for (const auto& probe : probes)
    if (const auto error = probe.error()) {
      sum_of_ratios += *probe.ratio(*probe.deepest());
      (probe.near_fixed ? near : elsewhere).push_back(*error);
      reference_errors.push_back(*probe.error_of(probe.finer));
    }
  auto both = near;
  both.insert(both.end(), elsewhere.begin(), elsewhere.end());
  const auto part = [](const std::vector<double>& errors) {
    const auto all = ErrorStatistics::of(errors);
    return DistancePart{static_cast<std::int32_t>(all.n), all.mean, all.p95};
  };
  const auto at_rest_part = [&](double PlaceAtRest::*of) {
    std::vector<double> errors;
    for (const auto& place : at_rest.places)
      if (std::isfinite(place.*of)) errors.push_back(place.*of);
    return part(errors);
  };
  const auto all = part(both);
  FinerDistance distance{.is_measured = true,
                         .element = name(scene.solver.element),
                         .reference = name(reference),
                         .probes = all.places,
                         .tool_radius_m = tool_radius_m,
                         .mean = all.mean,
                         .p95 = all.p95,
                         .nodes = nodes,
                         .solved = static_cast<std::int32_t>(std::ranges::count_if(
                             probes, [](const auto& probe) { return !probe.finer.status.empty(); })),
                         .has_parts = all.places > 0,
                         .near_fixed = part(near),
                         .elsewhere = part(elsewhere),
                         .element_at_rest = at_rest_part(&PlaceAtRest::element),
                         .cells_at_rest = at_rest_part(&PlaceAtRest::cells),
                         .shape_at_rest = at_rest_part(&PlaceAtRest::shape),
                         .unknowns_factor = unknowns_factor,
                         .force_ratio = all.places > 0 ? sum_of_ratios / all.places : 0};
  if (distance.cells_at_rest.places > 0) distance.of_reference = part(reference_errors);
  return distance;
}

namespace {

double surface_edge_m(const Mesh& mesh, const NodeSets& sets) {
  const auto edges = surface_edges_at(sets.active, mesh);
  return std::accumulate(edges.begin(), edges.end(), 0.0) / static_cast<double>(edges.size());
}

/// Why the scene has no Taylor-Hood variant; empty if it has one.
std::string taylor_hood_obstacle(const Scene& scene) {
  if (scene.solver.element->is_shell) return "a shell has one element only";
  if (scene.solver.element == element_named("taylor-hood")) return "it is the element of the scene";
  const bool positive = std::ranges::all_of(materials(scene), [](const auto* m) { return m->lame_lambda_Pa > 0; });
  return positive ? "" : "it needs materials with lambda > 0";
}

constexpr std::size_t max_places_at_rest = 24;

/// The solver of a variant, which is created at its first ray.
class VariantSolver {
 public:
  /// @param end_s  time since the start at which a ray is abandoned. @param elapsed_s  returns the time since the start
  VariantSolver(VariantBody body, double end_s, std::function<double()> elapsed_s, const ShouldStop& stop)
      : _body(std::move(body)), _end_s(end_s), _elapsed_s(std::move(elapsed_s)), _stop(stop) {}

  const VariantBody& body() const { return _body; }
  const DatabaseHeader& header() const { return *_header; }
  bool is_stopping() const { return _is_stopping; }

  /// @return false if the ray was abandoned
  bool solve(const CheckedRay& ray, VariantForces& forces) {
    if (!_solver) {
      _header = database_header(_body.scene, _body.mesh, _body.sets);
      _solver = std::make_unique<ProbeSolver>(_body.scene, _body.mesh, _body.sets);
    }
    const auto solved = solve_rays(*_solver, *_header, {{ray.active, ray.direction}}, {}, [&] {
      _is_stopping = _is_stopping || (_stop && _stop());
      return _is_stopping || _elapsed_s() > _end_s;
    });
    if (solved.interrupted || solved.rays.empty()) return false;
    const Ray& result = solved.rays.front();
    forces.status = result.status;
    for (std::size_t i = 0; i < result.status.size(); ++i)
      forces.force_N.push_back({result.force[3 * i], result.force[3 * i + 1], result.force[3 * i + 2]});
    return true;
  }

 private:
  VariantBody _body;
  double _end_s;
  std::function<double()> _elapsed_s;
  const ShouldStop& _stop;
  bool _is_stopping = false;
  std::optional<DatabaseHeader> _header;
  std::unique_ptr<ProbeSolver> _solver;
};

}  // namespace

Variant finer_reference(const Scene& scene) {
  return taylor_hood_obstacle(scene).empty() ? Variant::taylor_hood : Variant::half_size;
}

void require_variant(const Scene& scene, Variant v) {
  if (const auto why = v == Variant::taylor_hood ? taylor_hood_obstacle(scene) : ""; !why.empty())
    throw input_error("there is no such reference for this scene: " + why, fmt::format("--reference {}", name(v)),
                      "give --reference half-size");
}

VariantBody variant_body(Variant v, VariantBody body) {
  if (v == Variant::taylor_hood) body.scene.solver.element = element_named("taylor-hood");
  if (v == Variant::half_size) {
    body.sets.fixed = refined(body.sets.fixed, mesh_edges(body.mesh), body.mesh.n_nodes());
    body.mesh = refined(body.mesh);
  }
  return body;
}

double variant_unknowns(Variant v, Element element, const Mesh& mesh) {
  const auto n = static_cast<double>(mesh.n_nodes()), e = static_cast<double>(mesh_edges(mesh).size());
  if (v == Variant::scene) return unknowns_of(element, n, e);
  if (v == Variant::taylor_hood) return unknowns_of(element_named("taylor-hood"), n, e);
  const auto c = static_cast<double>(mesh.n_cells());
  const auto faces = (4 * c + static_cast<double>(mesh.surface.rows())) / 2;
  return unknowns_of(element, n + e, mesh.cells.cols() == 4 ? 2 * e + 3 * faces + c : 2 * e + 3 * c);
}

double patch_radius_for_node(double edge_m, double max_displacement_m) {
  // A patch of less than two edges is not resolved (docs/extremes.md), and one that is pushed in by much more than half
  // its radius crushes the surface under it (docs/decisions/round-tool.md).
  return std::max(2 * edge_m, max_displacement_m / 0.6);
}

Scene compared_scene(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  constexpr int max_increments = 6;  // more increments do not change the comparison
  Scene common = scene;
  common.probe.increments = std::min(scene.probe.increments, max_increments);
  common.database.tangents = false;
  common.database.fields.clear();
  if (scene.probe.kind == ProbeKind::node) {
    common.probe.kind = ProbeKind::patch;
    common.probe.tool_radius_m = patch_radius_for_node(surface_edge_m(mesh, sets), scene.probe.max_displacement_m);
  }
  return common;
}

double unknowns_of(Element element, double nodes, double edges) {
  const double points = element->displacement_degree > 1 ? nodes + edges : nodes;
  const double pressures = element->mixed ? nodes : 0;
  return 3 * points + pressures + (element->is_shell ? 3 * edges : 0);
}

NodeList answered_nodes(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  if (scene.probe.kind != ProbeKind::patch || sets.active.size() < 3) return sets.active;
  auto all = probe_coordinates(mesh.nodes, mesh.surface, sets.active, sets.fixed, scene.probe.tool_radius_m).covered;
  all.insert(all.end(), sets.active.begin(), sets.active.end());
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

CheckedRays choose_checked_rays(const DatabaseHeader& header, const std::vector<char>& requested, double radius_m,
                                std::size_t wanted) {
  const auto& [mesh, sets] = std::tie(header.mesh, header.sets);
  const std::size_t n_directions = header.directions.size();
  Eigen::VectorXd area = Eigen::VectorXd::Zero(mesh.n_nodes());
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t)
    for (const auto node : mesh.surface.row(t))
      area[node] += normal_of(corners_of(mesh.nodes, mesh.surface, t)).norm() / 6;
  Eigen::Index axis = 0;
  (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).maxCoeff(&axis);
  std::vector<std::tuple<bool, double, std::size_t>>
      order;  // (near fixed nodes, coordinate along the longest axis, index of the active node)
  for (std::size_t a = 0; a < sets.active.size(); ++a) {
    const auto first = requested.begin() + static_cast<std::ptrdiff_t>(a * n_directions);
    if (std::count(first, first + static_cast<std::ptrdiff_t>(n_directions), char{1}) == 0) continue;
    const Eigen::RowVector3d x = mesh.nodes.row(sets.active[a]);
    const bool near = std::ranges::any_of(
        sets.fixed, [&, &nodes = mesh.nodes](std::int32_t node) { return (nodes.row(node) - x).norm() < radius_m; });
    order.emplace_back(near, x[axis], a);
  }
  std::ranges::sort(order);
  std::vector<double> cumulative_area;
  CheckedRays chosen;
  for (const auto& [near, x, a] : order) {
    cumulative_area.push_back((cumulative_area.empty() ? 0 : cumulative_area.back()) + area[sets.active[a]]);
    chosen.near_share += near ? area[sets.active[a]] : 0;
  }
  if (!order.empty()) chosen.near_share /= cumulative_area.back();
  const Points normals = node_normals(mesh);
  std::vector<char> is_chosen(order.size(), 0);
  while (chosen.rays.size() < std::min(wanted, order.size())) {
    double integer_part = 0;
    const double position =
        std::modf((static_cast<double>(chosen.rays.size()) + 0.5) * std::numbers::phi, &integer_part);
    auto i = static_cast<std::size_t>(std::ranges::lower_bound(cumulative_area, position * cumulative_area.back()) -
                                      cumulative_area.begin());
    while (is_chosen[i % order.size()]) ++i;
    is_chosen[i % order.size()] = 1;
    const auto& [near, x, a] = order[i % order.size()];
    std::size_t best = n_directions;
    double smallest_deviation = std::numeric_limits<double>::infinity();
    for (std::size_t d = 0; d < n_directions; ++d) {
      const double inward = -normals.row(sets.active[a]).dot(to_eigen(header.directions[d]).transpose());
      const double deviation = std::abs(inward - std::array{1.0, 0.0, -1.0}[chosen.rays.size() % 3]);
      if (requested[a * n_directions + d] && deviation < smallest_deviation) smallest_deviation = deviation, best = d;
    }
    chosen.rays.push_back({static_cast<std::int32_t>(a), static_cast<std::int32_t>(best), near});
  }
  return chosen;
}

DiscretizationReport check_discretization(const Scene& scene, const Mesh& mesh, const NodeSets& own_sets,
                                          const DiscretizationOptions& options, const OnProgress& progress,
                                          const ShouldStop& stop) {
  const std::function<double()> elapsed_s = [&options, start = options.clock()] { return options.clock() - start; };
  require_variant(scene, options.reference);
  const double finer_unknowns = variant_unknowns(options.reference, scene.solver.element, mesh);
  if (const auto why = memory_shortage(finer_unknowns, options); !why.empty())
    throw input_error("the finer solution does not fit into the memory", why,
                      "use a coarser mesh, or a machine with more memory; with check_probes = 0 phynness run goes on "
                      "without it");
  const Scene common = compared_scene(scene, mesh, own_sets);
  const NodeSets sets{own_sets.fixed, answered_nodes(scene, mesh, own_sets), {}};
  const auto header = database_header(common, mesh, sets);
  DiscretizationReport report;
  report.reference = options.reference;
  report.mean_edge_m = measure_quality(mesh).mean_edge_m;
  report.patch_for_node = scene.probe.kind == ProbeKind::node;
  report.tool_radius_m = common.probe.tool_radius_m;
  report.tool_edges = report.tool_radius_m / surface_edge_m(mesh, own_sets);
  report.depth_m = header.magnitudes_m;
  const bool finer_mesh = options.reference == Variant::half_size;
  report.nodes = mesh.n_nodes() + (finer_mesh ? static_cast<std::int32_t>(mesh_edges(mesh).size()) : 0);
  report.unknowns_factor = finer_unknowns / variant_unknowns(Variant::scene, common.solver.element, mesh);
  const auto max_probes = static_cast<std::size_t>(options.probes);
  auto [rays, near_share] = choose_checked_rays(header, requested_rays(common, mesh, header), report.tool_radius_m,
                                                std::max(max_probes, max_places_at_rest));
  report.near_share = near_share;
  if (rays.empty())
    throw input_error("the scene has no rays", scene.source_name, "check nodes.active and the directions");
  std::vector<PlaceAtRest> places;
  for (const auto& ray : rays)
    places.push_back({.node = sets.active[static_cast<std::size_t>(ray.active)], .near_fixed = ray.near_fixed});
  if (rays.size() > max_probes) rays.resize(max_probes);

  const VariantBody body{common, mesh, {sets.fixed, sets.active, {}}};
  if (mesh.cells.cols() == 4)
    report.at_rest = compare_at_rest(body, options.reference, places, options, elapsed_s, stop);

  VariantSolver own(body, options.seconds, elapsed_s, stop);
  std::optional<VariantSolver> finer;
  const Points normals = node_normals(mesh);
  double finer_ray_s = 0;
  std::int64_t compared = 0;
  const double start_s = elapsed_s();
  for (const auto& ray : rays) {
    report.interrupted = stop && stop();
    const double mean_s = compared > 0 ? (elapsed_s() - start_s) / static_cast<double>(compared) : 0;
    if (report.interrupted || elapsed_s() + mean_s > options.seconds) break;
    CheckedProbe probe;
    probe.node = places[report.probes.size()].node;
    probe.near_fixed = ray.near_fixed;
    probe.direction = header.directions[static_cast<std::size_t>(ray.direction)];
    probe.inward = -normals.row(probe.node).dot(to_eigen(probe.direction).transpose());
    if (!report.at_rest.places.empty()) {
      const auto& change = report.at_rest.places[report.probes.size()].finest_over_reference;
      if (change.allFinite()) probe.finest_over_reference = change;
    }
    if (!own.solve(ray, probe.own)) break;
    report.probes.push_back(probe);
    if (progress) progress(2 * compared + 1, 2 * std::ssize(rays));
    if (!finer) {  // the estimate may be ten times too large
      finer_ray_s = (elapsed_s() - start_s) * std::pow(report.unknowns_factor, cost_exponent);
      if (finer_ray_s > 10 * (options.seconds - elapsed_s())) break;
      finer.emplace(variant_body(options.reference, own.body()), options.seconds, elapsed_s, stop);
    }
    if (!finer->solve(ray, report.probes.back().finer)) break;
    ++compared;
    if (progress) progress(2 * compared, 2 * std::ssize(rays));
    if (is_known(report.probes, near_share)) break;
  }
  report.interrupted = report.interrupted || own.is_stopping() || (finer && finer->is_stopping());
  const bool is_done = report.interrupted || is_known(report.probes, near_share);
  report.left_out = is_done ? 0 : std::ssize(rays) - compared;
  report.seconds = elapsed_s();
  report.sufficient_s = compared > 0 ? start_s + (report.seconds - start_s) / static_cast<double>(compared) *
                                                     static_cast<double>(is_done ? compared : std::ssize(rays))
                                     : 2 * std::max(report.seconds, finer_ray_s) * static_cast<double>(rays.size());
  return report;
}

}  // namespace phynness
