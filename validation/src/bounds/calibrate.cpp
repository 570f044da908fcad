// Solves the random rays on which bounds are calibrated.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/locking.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/sizes.hpp>
#include <phynness/validation/tools.hpp>
#include <set>

#include "check/compared_scene.hpp"
#include "measure/coupled_states.hpp"
#include "measure/packed.hpp"
#include "measure/shared_work.hpp"
#include "measure/tool_rays.hpp"

namespace phynness {
namespace {

constexpr std::size_t states_per_ray = 3, rays_per_node = 5;
/// The distance to a finer solution depends on the place more than on the state.
constexpr std::size_t finer_rays_per_node = 2;
/// A ray of one tool between nodes, or of a body's tools, has a place of its own, because errors at one place are
/// alike; its two states take about as long as the three of a ray.
constexpr double increments_per_coupled = 3;
/// The same of up to three tools at every depth; measured: the demo, 11 s for 160 rays.
constexpr double increments_per_body_ray = 12;
/// The nodes are a sample of clusters: with fewer, 0.95 (1 + 1 / n) is above 1 and nothing is known of the next node.
constexpr std::size_t min_nodes = 20;
/// The number of coupled rays of each kind (docs/decisions/error-bounds.md).
std::int64_t coupled_rays_per_kind(std::int64_t rays) { return 50 + rays / 10; }

/// Draws a direction in which the node has a trained range.
Vec3 trained_direction(const NamedOrgan& model, std::int32_t node, std::mt19937_64& random) {
  Vec3 e{};
  for (int attempt = 0; attempt < 1000; ++attempt) {
    e = random_direction(random);
    if (model.trained_depth(node, e) > 0) break;
  }
  return e;
}

struct NodeStates {
  std::vector<double> states;  ///< packed BoundState records
  std::int64_t rays = 0, failed = 0;
};

/// Draws indices of nodes from a low-discrepancy sequence, so that every prefix is an even sample of the model: the
/// finished nodes of an interrupted calibration, and the nodes of a smaller calibration.
std::vector<std::size_t> sampled_nodes(std::size_t n_nodes, std::size_t n_active, std::mt19937_64& random) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  std::vector<std::size_t> sample;
  std::vector<char> is_sampled(n_active);
  for (double position = uniform(random); sample.size() < n_nodes; position = std::fmod(position + golden, 1)) {
    const auto i = static_cast<std::size_t>(position * static_cast<double>(n_active));
    if (!is_sampled[i]) sample.push_back(i);
    is_sampled[i] = 1;
  }
  return sample;
}

/// Draws the next ray of a node. @return a ray without fractions if no drawn depth is inside the trained range
ToolRay draw_ray(const NamedOrgan& model, std::int32_t node, std::mt19937_64& random) {
  const double largest = model.model().max_displacement_m;
  const Vec3 e = trained_direction(model, node, random);
  const double trained = model.trained_depth(node, e);
  ToolRay ray{{{{node, -1, -1}, {1, 0, 0}, {largest * e[0], largest * e[1], largest * e[2]}}}, {}};
  for (std::size_t i = 0; i < states_per_ray; ++i) {
    const double fraction = 1 - uniform(random);
    if (fraction * largest <= trained) ray.fractions.push_back(fraction);
  }
  std::sort(ray.fractions.begin(), ray.fractions.end());
  return ray;
}

void add_states(const NamedOrgan& model, std::size_t index, const ToolRay& ray, const std::vector<Vec3>& forces,
                NodeStates& out) {
  const double largest = model.model().max_displacement_m;
  Vec3 e{};
  for (std::size_t k = 0; k < 3; ++k) e[k] = ray.tools[0].displacement[k] / largest;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const phn_tool tool = tools_at(ray, ray.fractions[i])[0];
    const double* d = tool.displacement;
    const Vec3 predicted = model.force(ray.tools[0].nodes[0], {d[0], d[1], d[2]});
    const Vec3& solved = forces[i];
    const double error = std::hypot(predicted[0] - solved[0], predicted[1] - solved[1], predicted[2] - solved[2]);
    const double size = std::hypot(solved[0], solved[1], solved[2]);
    pack(out.states, BoundState{static_cast<std::int32_t>(index), e, largest * ray.fractions[i], error, size});
  }
  out.failed += forces.size() < ray.fractions.size();
}

/// A node's index, and the columns of its stiffness [N/m].
struct NodeAtRest {
  std::int32_t node = 0;
  std::array<double, 9> stiffness{};
};

/// Collects on rank 0 the stiffness at rest of every node that has a solution. Collective.
std::vector<NodeAtRest> stiffnesses_at_rest(const SolverSession& session, const NamedOrgan& model,
                                            const ShouldStop& stop, RayForces& rays) {
  std::vector<double> rows;
  session.together([&] {
    distribute(session, std::ssize(model.model().nodes), {}, stop, [&](std::size_t i) {
      const auto columns = rays.solve({{{{model.model().nodes[i].node, -1, -1}, {1, 0, 0}, {}}}, {}});
      if (columns.size() < 3) return;
      NodeAtRest at_rest{static_cast<std::int32_t>(i)};
      for (std::size_t k = 0; k < 3; ++k) std::ranges::copy(columns[k], at_rest.stiffness.begin() + 3 * k);
      pack(rows, at_rest);
    });
  });
  return unpacked<NodeAtRest>(session.gather(rows));
}

/// The relative distance to a finer solution is nearly constant along a ray and equals that of the stiffness at rest.
/// The predictor is therefore the logarithm of the difference of the stiffnesses in the direction of each displacement.
/// @param at_rest  stiffnesses of the finer solution
void predict_from_rest_stiffness(const NamedOrgan& model, const std::vector<NodeAtRest>& at_rest,
                                 BoundPredictors& predictors) {
  constexpr double floor = 1e-4;
  if (at_rest.size() < model.model().nodes.size()) return;  // a solve failed, or the run was stopped
  const auto& displacements = model.model().displacements;
  for (const auto& [number, stiffness] : at_rest) {
    const auto node = static_cast<std::size_t>(number);
    std::array<double, 9> own{};
    Vec3 force;
    double energy = 0;
    if (model.organ().hold(tool_at(model.model().nodes[node].node, Vec3{}), force, energy, own) < 0) return;
    const Eigen::Matrix3d difference =
        Eigen::Map<const Eigen::Matrix3d>(own.data()) - Eigen::Map<const Eigen::Matrix3d>(stiffness.data());
    for (Eigen::Index row = 0; row < displacements.rows(); ++row)
      predictors.compression[node][static_cast<std::size_t>(row)] =
          std::log(std::max(floor, (difference * displacements.row(row).transpose().normalized()).norm() *
                                       model.model().max_displacement_m / predictors.largest_N[node]));
  }
}

/// The errors of each fifth of the nodes with bounds that are calibrated on the other nodes; of the rays instead of the
/// nodes if every node has rays.
std::vector<BoundedError> cross_validated_errors(const NamedOrgan& model, const BoundPredictors& predictors,
                                                 const std::vector<BoundState>& states, std::int64_t n_rays,
                                                 double coverage) {
  constexpr std::size_t n_folds = 5;
  std::set<std::int32_t> nodes;
  for (const auto& state : states) nodes.insert(state.node);
  const bool all_nodes = nodes.size() == model.model().nodes.size();
  const auto cluster = [&](const BoundState& s) { return std::pair{s.node, all_nodes ? s.direction : Vec3{}}; };
  std::map<std::pair<std::int32_t, Vec3>, std::size_t> fold;
  for (const auto& state : states) fold.emplace(cluster(state), fold.size() % n_folds);
  std::vector<BoundedError> errors;
  for (std::size_t p = 0; p < std::min(n_folds, fold.size()) && fold.size() > 1; ++p) {
    std::vector<BoundState> training, held_out;
    for (const auto& state : states) (fold[cluster(state)] == p ? held_out : training).push_back(state);
    const auto share = static_cast<std::int64_t>(n_rays * static_cast<std::int64_t>(training.size()) /
                                                 static_cast<std::int64_t>(states.size()));
    const NamedOrgan other(add_bounds(model.model(), predictors, training, std::max<std::int64_t>(1, share), coverage),
                           model.mesh(), "model");
    const auto fold_errors = bounded_errors(other, held_out);
    errors.insert(errors.end(), fold_errors.begin(), fold_errors.end());
  }
  return errors;
}

void set_medians(const NamedOrgan& bounded, const std::vector<BoundState>& states, BoundReport& report) {
  std::vector<double> bounds, shares;
  for (const auto& error : bounded_errors(bounded, states)) {
    shares.push_back(error.bound_N / std::max(states[bounds.size()].force_N, 1e-300));
    bounds.push_back(error.bound_N);
  }
  report.median_bound_N = ErrorStatistics::of(bounds).median;
  report.median_share = ErrorStatistics::of(shares).median;
}

using PlannedRay = std::pair<std::int32_t, CoupledKind>;  ///< number of the ray among those of its kind

/// Alternates the kinds, because their costs differ.
std::vector<PlannedRay> planned_rays(const CoupledRays& coupled, std::int64_t rays,
                                     const std::vector<CoupledKind>& kinds) {
  std::vector<PlannedRay> planned;
  const auto per_kind = static_cast<std::int32_t>(coupled_rays_per_kind(rays));
  for (std::int32_t ray = 0; ray < per_kind; ++ray)
    for (const auto kind : kinds)
      if (coupled.is_possible(kind)) planned.emplace_back(ray, kind);
  return planned;
}

/// Solves the planned rays. Collective. @param seed  seed of the first ray. @return all states on rank 0
std::vector<CoupledState> solve_coupled(const SolverSession& session, const CoupledRays& coupled,
                                        const std::vector<PlannedRay>& planned, std::uint64_t seed,
                                        const OnProgress& progress, const ShouldStop& stop, RayForces& rays,
                                        BoundReport& report) {
  std::array<DrawnStates, 2> drawn;
  std::vector<double> rows;
  std::int64_t finished = 0, failed = 0;
  const bool is_running = session.sum(stop && stop() ? 1 : 0) == 0;
  session.together([&] {
    finished = distribute(session, is_running ? std::ssize(planned) : 0, progress, stop, [&](std::size_t i) {
      const auto [number, kind] = planned[i];
      // The random numbers of one tool do not depend on whether rays of several tools are planned.
      std::mt19937_64 ray_random(seed + static_cast<std::uint64_t>(2 * number + static_cast<int>(kind)));
      auto ray = coupled.draw(ray_random, number, kind, drawn[static_cast<std::size_t>(kind)]);
      if (ray.fractions.empty()) return;
      const auto forces = rays.solve(ray);
      failed += forces.size() < ray.states.size();
      for (std::size_t f = 0; f < forces.size(); ++f) {
        ray.states[f].force_N = forces[f];
        pack(rows, ray.states[f]);
      }
    });
  });
  report.planned_coupled_rays = std::ssize(planned);
  report.coupled_rays = session.total(finished);
  report.failed_coupled_rays = session.total(failed);
  for (std::size_t kind = 0; kind < drawn.size(); ++kind) {
    const double all = session.sum(drawn[kind].all), flagged = session.sum(drawn[kind].flagged);
    if (all > 0) report.coupled[kind].flagged = flagged / all;
  }
  auto states = unpacked<CoupledState>(session.gather(rows));
  std::ranges::stable_sort(states, {}, &CoupledState::ray);
  return states;
}

/// Draws a ray of each kind before the solves. @return the kinds of which some states are not flagged
std::vector<CoupledKind> unflagged_kinds(const CoupledRays& coupled, std::uint64_t seed, const ReducedBody& body,
                                         const OnNote& note, BoundReport& report) {
  std::vector<CoupledKind> kinds;
  for (const auto kind : {CoupledKind::one, CoupledKind::several}) {
    DrawnStates drawn;
    std::mt19937_64 random(seed);
    if (!coupled.is_possible(kind) || !coupled.draw(random, 0, kind, drawn).fractions.empty()) {
      kinds.push_back(kind);
      continue;
    }
    report.coupled[static_cast<std::size_t>(kind)].flagged = 1;
    note(fmt::format(
        "{} will have no bound: all random states are refused or have warnings ({} of {} are unsettled); {}",
        kind == CoupledKind::one ? "one tool" : "several tools", drawn.unsettled, drawn.all,
        2 * drawn.unsettled >= drawn.all ? larger_body(body.modes.cols(), std::ssize(body.shear_m3))
                                         : "probe a larger part of the surface, where tools can be apart"));
  }
  return kinds;
}

}  // namespace

FinerCost finer_cost(const Database& database, const Scene& scene, const BoundSpec& spec, int ranks) {
  const auto& header = database.header();
  if (scene.probe.kind == ProbeKind::node)
    throw input_error("the force at a single node has no limit on finer meshes, and no finer solution tells its error",
                      "probe.kind = \"node\"", "give the scene a round tool: kind = \"patch\", tool_radius_m");
  require_variant(scene, spec.reference);
  const double locked = expected_force_ratio(scene);
  if (spec.reference == Variant::half_size && locked > warned_force_ratio)
    throw input_error("cells of half the size lock, too, and tell no error",
                      fmt::format("element {}, K/mu = {:.4g}: forces about {}", name(scene.solver.element),
                                  most_locked(scene).bulk_to_shear(), ratio_in_words(locked)),
                      "give --reference taylor-hood");
  const auto summary = summarize(database);
  double increments = 0;
  for (const auto& [status, count] : summary.states)
    if (status == Status::converged) increments += static_cast<double>(count);
  const double unknowns = variant_unknowns(spec.reference, scene.solver.element, header.mesh);
  const double finer = unknowns / variant_unknowns(Variant::scene, scene.solver.element, header.mesh);
  const auto at_rest =
      static_cast<double>(header.sets.active.size());  // the stiffness at a node costs as much as an increment
  Scene sized = scene;
  sized.validation.calibration_rays = spec.rays;
  return {(sizes_of_checks(sized, header, true).calibration_increments + at_rest) * summary.seconds /
              std::max(1.0, increments) * std::pow(finer, cost_exponent) / ranks,
          factor_bytes(unknowns) * ranks};
}

double calibration_increments(std::int64_t rays, bool between) {
  return static_cast<double>(states_per_ray) * static_cast<double>(rays) +
         (between ? increments_per_coupled * static_cast<double>(coupled_rays_per_kind(rays)) : 0);
}

double body_calibration_increments(std::int64_t rays) {
  return 2 * increments_per_body_ray * static_cast<double>(coupled_rays_per_kind(rays));
}

void calibrate(const SolverSession& session, const Database& database, const NamedOrgan& model, ReducedBody& body,
               const BoundSpec& spec, const OnNote& note, const OnProgress& progress, const ShouldStop& stop,
               BoundReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  const auto& header = database.header();
  std::optional<NamedOrgan> loaded;
  session.together([&] {
    require_scene(header);
    loaded = NamedOrgan::body(write_body_text(body), "body");
  });
  const ProbeSpec probe = stored_scene(header).probe;
  RayForces rays(header, Variant::scene, stop);
  const CoupledRays coupled(model, probe, &*loaded);
  const auto kinds = unflagged_kinds(coupled, spec.seed, body, note, report);  // the same on every rank
  const auto planned = planned_rays(coupled, spec.rays, kinds);
  const auto states = solve_coupled(session, coupled, planned, spec.seed * 1000003, progress, stop, rays, report);
  session.together([&] {
    if (session.rank() == 0) add_coupled_bounds(body, spec.coverage, states, report.coupled);
    if (session.rank() == 0 && body.bounds.rows() == 0)
      throw failure("too few rays were solved for bounds of the body",
                    fmt::format("{} of {} rays", report.coupled_rays, report.planned_coupled_rays),
                    "run it again; nothing was written");
  });
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Model calibrate(const SolverSession& session, const Database& database, const NamedOrgan& model, const BoundSpec& spec,
                const OnProgress& progress, const ShouldStop& stop, BoundReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  const auto& header = database.header();
  BoundPredictors predictors;
  session.together([&] {
    predictors = bound_predictors(model.model(), database);
    require_scene(header);
  });
  const std::size_t n_active = model.model().nodes.size();
  const auto n_rays = static_cast<std::size_t>(spec.rays);
  const std::size_t n_nodes = std::min(
      n_active, std::max(min_nodes, n_rays / (spec.reference == Variant::scene ? rays_per_node : finer_rays_per_node)));
  std::mt19937_64 random(spec.seed);
  const auto sample = sampled_nodes(n_nodes, n_active, random);
  RayForces rays(header, spec.reference, stop);
  const CoupledRays coupled(model, stored_scene(header).probe);
  const auto coupled_rays = planned_rays(coupled, spec.rays, {CoupledKind::one});
  report.reference = spec.reference;
  const auto n_items = static_cast<std::int64_t>(n_nodes) + std::ssize(coupled_rays);
  const auto counted = [&](std::int64_t before) {
    return [&, before](std::int64_t done, std::int64_t) {
      if (progress) progress(before + done, n_items);
    };
  };
  NodeStates solved;
  std::int64_t finished = 0;
  session.together([&] {
    finished = distribute(session, static_cast<std::int64_t>(n_nodes), counted(0), stop, [&](std::size_t i) {
      // The rays of a node do not depend on the number of ranks or of later nodes.
      std::mt19937_64 node_random(spec.seed * 1000003 + sample[i]);
      NodeStates of_node;
      of_node.rays = static_cast<std::int64_t>(n_rays / n_nodes + (i < n_rays % n_nodes));
      for (std::int64_t ray = 0; ray < of_node.rays; ++ray) {
        const auto next = draw_ray(model, model.model().nodes[sample[i]].node, node_random);
        if (!next.fractions.empty()) add_states(model, sample[i], next, rays.solve(next), of_node);
      }
      solved.states.insert(solved.states.end(), of_node.states.begin(), of_node.states.end());
      solved.rays += of_node.rays;
      solved.failed += of_node.failed;
    });
  });
  const auto at_rest =
      spec.reference == Variant::scene ? std::vector<NodeAtRest>() : stiffnesses_at_rest(session, model, stop, rays);
  const auto coupled_states = solve_coupled(session, coupled, coupled_rays, spec.seed * 1000003 + n_active,
                                            counted(static_cast<std::int64_t>(n_nodes)), stop, rays, report);
  report.nodes = session.total(finished);
  report.planned_nodes = static_cast<std::int64_t>(n_nodes);
  report.rays = session.total(solved.rays);
  report.failed_rays = session.total(solved.failed);
  auto states = unpacked<BoundState>(session.gather(solved.states));
  std::ranges::stable_sort(states, {}, &BoundState::node);
  predict_from_rest_stiffness(model, at_rest, predictors);
  Model bounded = model.model();
  session.together([&] {
    if (report.nodes < static_cast<std::int64_t>(std::min(n_nodes, min_nodes)))
      throw failure("the calibration was interrupted before it had enough nodes for bounds",
                    fmt::format("{} of {} nodes", report.nodes, n_nodes), "run it again; nothing was written");
    if (session.rank() != 0) return;
    bounded = add_bounds(model.model(), predictors, states, report.rays, spec.coverage);
    report.states = static_cast<std::int64_t>(states.size());
    report.all_nodes = static_cast<std::size_t>(report.nodes) == n_active;
    const double range_m = bounded.max_displacement_m;
    report.left_out =
        coverage_of(cross_validated_errors(model, predictors, states, report.rays, spec.coverage), range_m);
    report.promised = promised_coverage(bounded);
    add_bound_between(bounded, model.mesh(), coupled_states, report.coupled[0]);
    bounded.bounds[0].reference = static_cast<std::int32_t>(spec.reference);
    set_medians(NamedOrgan(bounded, model.mesh(), "model"), states, report);
  });
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return bounded;
}

}  // namespace phynness
