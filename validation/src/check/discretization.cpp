#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/patch_warnings.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/error_statistics.hpp>

#include "compared_scene.hpp"

namespace phynness {

const char* name(Variant v) { return reference_names[static_cast<std::size_t>(v)]; }

std::optional<Variant> variant_named(std::string_view given) {
  const auto found = std::ranges::find(variants, given, [](Variant v) { return std::string_view(name(v)); });
  return found == variants.end() ? std::nullopt : std::optional(*found);
}

std::optional<double> CheckedProbe::ratio(Variant other, std::size_t depth) const {
  const auto &own = of(Variant::scene), &reference = of(other);
  if (!own.converged(depth) || !reference.converged(depth) || !(to_eigen(reference.force_N[depth]).norm() > 0))
    return {};
  return to_eigen(own.force_N[depth]).norm() / to_eigen(reference.force_N[depth]).norm();
}

std::optional<double> CheckedProbe::error(Variant other) const {
  const auto &own = of(Variant::scene), &reference = of(other);
  for (std::size_t depth = own.status.size(); depth-- > 0;)
    if (ratio(other, depth))
      return (to_eigen(own.force_N[depth]) - to_eigen(reference.force_N[depth])).norm() /
             to_eigen(reference.force_N[depth]).norm();
  return {};
}

RatioStatistics DiscretizationReport::ratios(Variant other, std::size_t depth) const {
  std::vector<double> all;
  for (const auto& probe : probes)
    if (const auto ratio = probe.ratio(other, depth)) all.push_back(*ratio);
  if (all.empty()) return {depth_m[depth]};
  std::sort(all.begin(), all.end());
  const std::size_t n = all.size();
  return {depth_m[depth], (all[(n - 1) / 2] + all[n / 2]) / 2, all.front(), all.back(), static_cast<std::int64_t>(n)};
}

VariantComparison DiscretizationReport::comparison(Variant other) const {
  VariantComparison comparison{{}, cost(other)};
  for (std::size_t i = 0; i < depth_m.size(); ++i) comparison.ratios.push_back(ratios(other, i));
  return comparison;
}

FinerDistance DiscretizationReport::distance(const Scene& scene, Variant other) const {
  std::vector<double> errors;
  for (const auto& probe : probes)
    if (const auto error = probe.error(other)) errors.push_back(*error);
  const auto all = ErrorStatistics::of(errors);
  const Element element = scene.solver.element;
  return {.is_measured = true,
          .element = name(element),
          .reference = name(other),
          .probes = static_cast<std::int32_t>(all.n),
          .tool_radius_m = tool_radius_m,
          .mean = all.mean,
          .p95 = all.p95,
          .nodes = cost(other).n_nodes,
          .solved = static_cast<std::int32_t>(
              std::ranges::count_if(probes, [&](const auto& probe) { return !probe.of(other).status.empty(); }))};
}

namespace {

double surface_edge_m(const Mesh& mesh, const NodeSets& sets) {
  const auto edges = surface_edges_at(sets.active, mesh);
  return std::accumulate(edges.begin(), edges.end(), 0.0) / static_cast<double>(edges.size());
}

/// Why a scene has no such variant; empty: it has.
std::string why_no_taylor_hood(const Scene& scene) {
  if (scene.solver.element->is_shell) return "a shell has one element only";
  if (scene.solver.element == element_named("taylor-hood")) return "it is the element of the scene";
  return scene.material.lame_lambda_Pa > 0 ? "" : "it needs a material with lambda > 0";
}

}  // namespace

Variant finer_reference(const Scene& scene) {
  return why_no_taylor_hood(scene).empty() ? Variant::taylor_hood : Variant::half_size;
}

void require_variant(const Scene& scene, Variant v) {
  if (const auto why = v == Variant::taylor_hood ? why_no_taylor_hood(scene) : ""; !why.empty())
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
  constexpr int most_increments = 6;  // more do not change the comparison
  Scene common = scene;
  common.probe.increments = std::min(scene.probe.increments, most_increments);
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

std::vector<std::pair<std::int32_t, std::int32_t>> choose_checked_rays(const DatabaseHeader& header,
                                                                       const std::vector<char>& requested, int wanted) {
  const auto& active = header.sets.active;
  const std::size_t n_directions = header.directions.size();
  const Points normals = node_normals(header.mesh);
  // Distance of each candidate from the fixed and the selected nodes.
  std::vector<double> distance(active.size(), std::numeric_limits<double>::infinity());
  const auto keep_away_from = [&](std::int32_t node) {
    for (std::size_t a = 0; a < active.size(); ++a)
      distance[a] = std::min(distance[a], (header.mesh.nodes.row(active[a]) - header.mesh.nodes.row(node)).norm());
  };
  for (const auto node : header.sets.fixed) keep_away_from(node);
  for (std::size_t a = 0; a < active.size(); ++a) {
    const auto first = requested.begin() + static_cast<std::ptrdiff_t>(a * n_directions);
    if (std::count(first, first + static_cast<std::ptrdiff_t>(n_directions), char{1}) == 0) distance[a] = 0;
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> chosen;
  for (int k = 0; k < wanted && k < static_cast<int>(active.size()); ++k) {
    const auto a = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    if (!(distance[a] > 0)) break;
    std::size_t best = n_directions;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t d = 0; d < n_directions; ++d) {
      const double inward = -normals.row(active[a]).dot(to_eigen(header.directions[d]).transpose());
      const double off = std::abs(inward - std::array{1.0, 0.0, -1.0}[static_cast<std::size_t>(k % 3)]);
      if (requested[a * n_directions + d] && off < least) least = off, best = d;
    }
    chosen.emplace_back(static_cast<std::int32_t>(a), static_cast<std::int32_t>(best));
    keep_away_from(active[a]);
  }
  return chosen;
}

namespace {

/// A body for solves, whose expensive parts are made when they are needed.
struct Body : VariantBody {
  double unknowns = 0;
  std::optional<DatabaseHeader> header;
  std::unique_ptr<ProbeSolver> solver;
};

/// Times of the rays of a variant.
struct Times {
  int n = 0;              ///< finished rays
  double finished_s = 0;  ///< their sum
  double vain_s = 0;      ///< the longest of those that were given up
};

class Check {
 public:
  Check(const Scene& scene, const Mesh& mesh, const NodeSets& sets, const DiscretizationOptions& options,
        const OnProgress& progress, const ShouldStop& stop);
  DiscretizationReport run();

 private:
  void prepare(Variant v);
  double expected_s(Variant v) const;
  const Times& times(Variant v) const { return _times[static_cast<std::size_t>(v)]; }
  bool solve(Variant v, std::size_t ray, double end);
  double compare(Variant reference, double end);
  void choose(std::deque<std::size_t>& waiting, double end);
  double elapsed() const { return _options.clock() - _start; }
  bool interrupted() { return _report.interrupted = _report.interrupted || (_stop && _stop()); }
  VariantCost& cost(Variant v) { return _report.costs[static_cast<std::size_t>(v)]; }
  Body& body(Variant v) { return _bodies[static_cast<std::size_t>(v)]; }
  const Body& body(Variant v) const { return _bodies[static_cast<std::size_t>(v)]; }

  const DiscretizationOptions& _options;
  const OnProgress& _progress;
  const ShouldStop& _stop;
  double _start = _options.clock();
  std::int64_t _done = 0;
  DiscretizationReport _report;
  std::array<Body, 3> _bodies;
  std::vector<std::pair<std::int32_t, std::int32_t>> _rays;
  std::array<Times, 3> _times;
};

Check::Check(const Scene& scene, const Mesh& mesh, const NodeSets& sets, const DiscretizationOptions& options,
             const OnProgress& progress, const ShouldStop& stop)
    : _options(options), _progress(progress), _stop(stop) {
  const Scene common = compared_scene(scene, mesh, sets);
  _report.mean_edge_m = measure_quality(mesh).mean_edge_m;
  _report.patch_for_node = scene.probe.kind == ProbeKind::node;
  _report.tool_radius_m = common.probe.tool_radius_m;
  _report.tool_edges = _report.tool_radius_m / surface_edge_m(mesh, sets);

  _rays = choose_checked_rays(database_header(common, mesh, sets),
                              requested_rays(common, mesh, database_header(common, mesh, sets)), _options.probes);
  if (_rays.empty())
    throw input_error("the scene has no rays", scene.source_name, "check nodes.active and the directions");
  NodeSets own{sets.fixed, sets.active, sets.active};
  static_cast<VariantBody&>(body(Variant::scene)) = {common, mesh, own};
  for (const auto v : variants) {
    body(v).unknowns = variant_unknowns(v, common.solver.element, mesh);
    cost(v).n_nodes = mesh.n_nodes();
  }
  cost(Variant::half_size).n_nodes += static_cast<std::int32_t>(mesh_edges(mesh).size());

  cost(Variant::taylor_hood).left_out = why_no_taylor_hood(common);
  if (const auto only = _options.reference) {
    require_variant(common, *only);
    cost(*only == Variant::half_size ? Variant::taylor_hood : Variant::half_size).left_out = "it is not asked for";
  }
  for (const auto v : {Variant::taylor_hood, Variant::half_size}) cost(v).possible = cost(v).left_out.empty();
}

/// Makes the body of a variant. The fine mesh is made only if it is affordable.
void Check::prepare(Variant v) {
  Body& b = body(v);
  if (b.solver) return;
  if (v != Variant::scene) static_cast<VariantBody&>(b) = variant_body(v, body(Variant::scene));
  b.header = database_header(b.scene, b.mesh, b.sets);
  b.solver = std::make_unique<ProbeSolver>(b.scene, b.mesh, b.sets);
}

/// Expected time of a ray; 0: unknown.
double Check::expected_s(Variant v) const {
  if (times(v).n > 0) return times(v).finished_s / times(v).n;
  if (times(v).vain_s > 0) return 2 * times(v).vain_s;
  if (v == Variant::scene) return 0;
  return expected_s(Variant::scene) * std::pow(body(v).unknowns / body(Variant::scene).unknowns, cost_exponent);
}

/// Solves one ray, and gives it up at `end`. @return whether it is solved
bool Check::solve(Variant v, std::size_t ray, double end) {
  const auto begin = elapsed();
  prepare(v);
  const auto before = elapsed();
  bool asked = false;
  const auto solved = solve_rays(*body(v).solver, *body(v).header, {_rays[ray]}, {}, [&] {
    asked = asked || (_stop && _stop());
    return asked || elapsed() > end;
  });
  const double seconds = elapsed() - before;
  auto& times = _times[static_cast<std::size_t>(v)];
  cost(v).seconds += elapsed() - begin;
  if (solved.interrupted || solved.rays.empty()) {
    _report.interrupted = _report.interrupted || asked;
    times.vain_s = std::max(times.vain_s, seconds);
    return false;
  }
  ++times.n;
  times.finished_s += seconds;
  if (_progress) _progress(++_done, static_cast<std::int64_t>(_rays.size() * variants.size()));
  auto& forces = _report.probes[ray].forces[static_cast<std::size_t>(v)];
  const Ray& result = solved.rays.front();
  forces.status = result.status;
  for (std::size_t i = 0; i < result.status.size(); ++i)
    forces.force_N.push_back({result.force[3 * i], result.force[3 * i + 1], result.force[3 * i + 2]});
  return true;
}

/// Limits the waiting probes to those that fit, with room for rays that take longer than the first.
void Check::choose(std::deque<std::size_t>& waiting, double end) {
  constexpr double room = 1.5;
  const double each = room * (expected_s(*_options.reference) + expected_s(Variant::scene));
  const double fitting = std::max(0.0, std::floor((end - elapsed()) / each));
  if (fitting >= static_cast<double>(waiting.size())) return;
  waiting.resize(static_cast<std::size_t>(fitting));
  _report.chosen = static_cast<std::int32_t>(1 + waiting.size());
}

/// Compares all probes with one reference until `end`, and solves those probes of the scene that are not yet solved. Of
/// the time that is left every waiting probe has the same share, but at least what it is expected to need. A probe that
/// needs more is given up and tried again after the others, if twice that time is left.
/// @return time that was used, and that the omitted probes are expected to need: more than there was, if any is omitted
double Check::compare(Variant reference, double end) {
  const double begin = elapsed();
  double omitted_s = 0;
  std::vector<double> least(_rays.size(), 0.0);  // twice the time that did not suffice
  std::deque<std::size_t> waiting(_rays.size());
  std::iota(waiting.begin(), waiting.end(), std::size_t{0});
  while (!waiting.empty() && !interrupted()) {
    const std::size_t ray = waiting.front();
    const bool is_new = _report.probes[ray].of(Variant::scene).status.empty();
    const Variant next = is_new ? Variant::scene : reference;
    const double expected = std::max(least[ray], expected_s(reference) + (is_new ? expected_s(next) : 0));
    const double before = elapsed(), left = end - before;
    // A time that no probe has needed is a guess, which may be ten times too large.
    const bool is_guess = least[ray] == 0 && (times(reference).n == 0 || (is_new && times(next).n == 0));
    const bool is_tried = times(reference).n > 0 || times(reference).vain_s > 0;
    waiting.pop_front();
    if (left <= 0 || expected > (is_guess ? 10 * left : left)) {
      cost(reference).left_out = "time";
      cost(reference).predicted_s = expected;
      omitted_s += expected;
      continue;
    }
    const double n_left = static_cast<double>(waiting.size() + 1);
    const double untried = _options.reference ? std::min(2.0, n_left) : n_left;
    const double fitting = is_tried ? std::clamp(std::floor(left / expected), 1.0, n_left) : untried;
    if (solve(next, ray, before + left / fitting)) {
      if (is_new) waiting.push_front(ray);
      if (!is_new && _options.reference && times(reference).n == 1) choose(waiting, end);
    } else {
      least[ray] = 2 * (elapsed() - before);
      waiting.push_back(ray);
    }
  }
  return elapsed() - begin + omitted_s;
}

DiscretizationReport Check::run() {
  const auto& mesh = body(Variant::scene).mesh;
  const Points normals = node_normals(mesh);
  const auto directions = exploratory_directions(body(Variant::scene).scene.probe.directions);
  for (const auto& ray : _rays) {
    CheckedProbe& probe = _report.probes.emplace_back();
    probe.node = body(Variant::scene).sets.active[static_cast<std::size_t>(ray.first)];
    probe.direction = directions[static_cast<std::size_t>(ray.second)];
    probe.inward = -normals.row(probe.node).dot(to_eigen(probe.direction).transpose());
  }
  // The cheaper comparison comes first and may take half of the time; what it leaves belongs to the other one.
  std::vector<Variant> references;
  for (const auto v : {Variant::taylor_hood, Variant::half_size})
    if (cost(v).possible) references.push_back(v);
  std::sort(references.begin(), references.end(),
            [&](Variant a, Variant b) { return body(a).unknowns < body(b).unknowns; });
  auto left = static_cast<double>(references.size());
  double needed_s = 0;  // of the comparisons so far
  for (const auto v : references) {
    const double own_s = compare(v, elapsed() + (_options.seconds - elapsed()) / left);
    _report.sufficient_s = std::max(_report.sufficient_s, needed_s + own_s * left--);
    needed_s += own_s;
  }
  std::erase_if(_report.probes, [](const CheckedProbe& probe) { return probe.of(Variant::scene).status.empty(); });
  if (body(Variant::scene).header) _report.depth_m = body(Variant::scene).header->magnitudes_m;
  _report.seconds = elapsed();
  return std::move(_report);
}

}  // namespace

DiscretizationReport check_discretization(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                          const DiscretizationOptions& options, const OnProgress& progress,
                                          const ShouldStop& stop) {
  return Check(scene, mesh, sets, options, progress, stop).run();
}

}  // namespace phynness
