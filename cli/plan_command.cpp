#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <phynness/meshes/meshes.hpp>
#include <phynness/precompute/planning.hpp>
#include <phynness/precompute/ray_tasks.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/several_tools.hpp>
#include <phynness/validation/sizes.hpp>
#include <phynness/validation/tools.hpp>
#include <thread>

#include "reduce_command.hpp"

namespace phynness::cli::plan_command {
namespace {

/// A relative standard error above this is reported; a plan then has an error of up to twice this value.
constexpr double acceptable_error = 0.125;
/// The speed of packing by one core; measured: 35 MB/s for demo.toml, 41 MB/s for liver_case3.toml.
constexpr double packing_B_per_s = 40e6;

struct Options {
  std::filesystem::path scene;
  OptionalPath json_file;
  std::optional<int> ranks;  ///< default: the number of processor cores of this machine
  int rays = 96;
  std::int64_t seed = 1;
};

// Keys of the JSON are the names of the members.
struct Measured {
  std::int64_t rays = 0, nodes = 0;
  double seconds_per_ray = 0, seconds_longest_ray = 0;
  std::optional<double> relative_standard_error;                          ///< of the mean, for enough nodes
  double start_seconds = 0, node_setup_seconds = 0, at_rest_seconds = 0;  ///< at_rest: all points
  PHYNNESS_FIGURES(rays, nodes, seconds_per_ray, seconds_longest_ray, relative_standard_error, start_seconds,
                   node_setup_seconds, at_rest_seconds)
};

struct Plan {
  std::int64_t rays = 0, rays_requested = 0;  ///< recorded rays, and solved ones
  std::size_t increments = 0, points_at_rest = 0;
  Measured measured;
  int ranks = 1;
  double wall_seconds = 0, core_hours = 0, memory_bytes_per_rank = 0, machine_memory_bytes = 0;
  double database_bytes = 0, log_bytes = 0;
  std::optional<double> check_seconds;  ///< limit of the check in run; empty if the scene sets the number of probes
  double check_memory_bytes = 0;        ///< without a check, and of a shell, 0
  std::int64_t calibration_rays = 0, probes = 0;
  double calibrate_seconds = 0, validate_seconds = 0;            ///< times in run
  std::optional<double> reduce_seconds, calibrate_body_seconds;  ///< of several tools
  int ranks_of_use = 1;
  PHYNNESS_FIGURES(rays, rays_requested, increments, points_at_rest, measured, ranks, wall_seconds, core_hours,
                   memory_bytes_per_rank, machine_memory_bytes, database_bytes, log_bytes, check_seconds,
                   check_memory_bytes, calibration_rays, probes, calibrate_seconds, validate_seconds, reduce_seconds,
                   calibrate_body_seconds, ranks_of_use)

  bool is_sample() const { return measured.rays < rays_requested; }
};

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

void print_failed_states(const std::map<Status, std::int64_t>& states) {
  std::int64_t failed = 0, all = 0;
  std::string reasons;
  for (const auto& [status, count] : states) {
    all += count;
    if (static_cast<int>(status) >= 0) continue;  // converged, or beyond the end of its ray
    failed += count;
    reasons += fmt::format("{}{} {} ({})", reasons.empty() ? "" : ", ", count, name(status), meaning(status));
  }
  if (failed > 0) message("warning: {} of {} increments failed: {}\n", failed, all, reasons);
}

/// Predicts the CPU time of the responses at rest from a few of them.
double seconds_at_rest(ProbeSolver& solver, const NodeList& points) {
  constexpr std::size_t max_points = 9;
  if (points.empty()) return 0;
  const auto cpu_s = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  const std::size_t n = std::min(max_points, points.size());
  const double start = cpu_s();
  solver.single_tool_at_rest(points.front());
  const double first_s = cpu_s();
  for (std::size_t i = 1; i < n; ++i) solver.single_tool_at_rest(points[i * points.size() / n]);
  const double mean_s = n > 1 ? (cpu_s() - first_s) / static_cast<double>(n - 1) : 0;
  return first_s - start + mean_s * static_cast<double>(points.size() - 1);
}

void measure(const LoadedScene& loaded, const DatabaseHeader& header, const std::vector<RayChoice>& chosen,
             Measured& measured) {
  ProbeSolver solver(loaded.scene, loaded.mesh, loaded.sets);
  std::vector<std::pair<std::int32_t, std::int32_t>> which;
  for (const auto& ray : chosen) which.emplace_back(ray.active, ray.direction);
  Progress progress("plan", "rays");
  const auto solved = solve_rays(
      solver, header, which, [&](std::int64_t done) { progress.update(done, std::ssize(chosen)); }, stop_requested);
  if (solved.interrupted)
    throw failure("interrupted", fmt::format("{} of {} rays solved", solved.rays.size(), chosen.size()),
                  "run the command again; fewer --rays take less time");
  const double total_s = static_cast<double>(std::clock()) / CLOCKS_PER_SEC, setup_s = sum(solved.node_setup_s);
  std::vector<double> seconds;
  std::map<Status, std::int64_t> states;
  for (const auto& ray : solved.rays) {
    seconds.push_back(sum(ray.seconds));
    for (const auto status : ray.status) ++states[status];
  }
  print_failed_states(states);
  const auto costs = costs_of(chosen, seconds);
  measured.rays = std::ssize(chosen);
  measured.nodes = std::ssize(solved.node_setup_s);
  measured.seconds_per_ray = costs.mean_s;
  measured.seconds_longest_ray = costs.longest_s;
  measured.relative_standard_error = costs.relative_error;
  measured.node_setup_seconds = setup_s / static_cast<double>(measured.nodes);
  measured.start_seconds = std::max(0.0, total_s - sum(seconds) - setup_s);
  measured.at_rest_seconds = seconds_at_rest(solver, header.sets.linear);
}

/// Predicts the sizes and times of calibrate, reduce and validate in run.
void plan_checks(const LoadedScene& loaded, const DatabaseHeader& header, Plan& plan) {
  const bool bounded = !schema::traits(loaded.scene.training.family).proportional;
  const auto sizes = sizes_of_checks(loaded.scene, header, bounded);
  const auto seconds = [&](double increments) {
    const double solving_s = increments * plan.measured.seconds_per_ray / static_cast<double>(plan.increments);
    return increments > 0 ? plan.measured.start_seconds + solving_s / plan.ranks : 0;
  };
  plan.calibration_rays = sizes.calibration_rays;
  plan.calibrate_seconds = seconds(sizes.calibration_increments);
  plan.probes = sizes.probes;
  plan.validate_seconds = seconds(sizes.validation_increments);
  if (loaded.scene.probe.tools == 1) return;
  plan.validate_seconds += seconds(increments_of({.pairs = pairs_in_run}));
  const auto points =
      loaded.mesh.n_cells() +
      (loaded.scene.solver.element == element_named("es-p1-p1") ? std::ssize(mesh_edges(loaded.mesh)) : 0);
  plan.reduce_seconds =
      plan.measured.start_seconds + reduction_s(plan.measured.seconds_per_ray / static_cast<double>(plan.increments),
                                                points, loaded.scene.probe.tools, plan.ranks);
  plan.calibrate_body_seconds = seconds(body_calibration_increments(sizes.calibration_rays));
}

Plan make_plan(const Options& options, const LoadedScene& loaded) {
  const auto header = database_header(loaded.scene, loaded.mesh, loaded.sets);
  const auto requested = requested_rays(loaded.scene, loaded.mesh, header);
  Plan plan;
  const auto& nodes = header.mesh.nodes;
  const auto chosen = choose_rays(nodes(header.sets.active, Eigen::all), nodes(header.sets.fixed, Eigen::all),
                                  requested, header.directions.size(), static_cast<std::size_t>(options.rays),
                                  static_cast<std::uint64_t>(options.seed));
  if (chosen.empty())
    throw input_error("the scene has no rays", options.scene.string(), "check nodes.active and the directions");
  measure(loaded, header, chosen, plan.measured);
  RunCosts costs{.start_s = plan.measured.start_seconds,
                 .ray_s = plan.measured.seconds_per_ray,
                 .longest_s = plan.measured.seconds_longest_ray,
                 .setup_s = plan.measured.node_setup_seconds};
  const auto n_directions = static_cast<std::ptrdiff_t>(header.directions.size());
  for (auto node = requested.begin(); node != requested.end(); node += n_directions) {
    const auto n = std::count(node, node + n_directions, char{1});
    costs.rays += n;
    costs.nodes += n > 0;
  }
  plan.rays = std::ssize(remaining_rays(header, std::vector<char>(requested.size(), 0)));
  plan.rays_requested = costs.rays;
  plan.increments = header.magnitudes_m.size();
  plan.log_bytes = static_cast<double>(plan.rays) * record_bytes(header);
  const double at_rest = at_rest_bytes(header);
  plan.points_at_rest = header.sets.linear.size();
  plan.database_bytes = static_cast<double>(requested.size()) * record_bytes(header) + at_rest;
  costs.packing_s = (plan.database_bytes - at_rest) / packing_B_per_s;
  plan.ranks = options.ranks.value_or(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  plan.wall_seconds = wall_seconds(costs, plan.ranks) + plan.measured.at_rest_seconds + at_rest / packing_B_per_s;
  if (const auto probes = loaded.scene.validation.check_probes; probes.value_or(0) == 0)
    plan.check_seconds =
        probes ? 0 : check_limit_s(plan.measured.seconds_per_ray * static_cast<double>(costs.rays), plan.ranks);
  if (plan.check_seconds != 0 && loaded.mesh.cells.cols() == 4)
    plan.check_memory_bytes = check_memory_bytes(loaded.scene, loaded.mesh);
  plan_checks(loaded, header, plan);
  plan.core_hours = plan.wall_seconds * plan.ranks / 3600;
  plan.ranks_of_use = max_useful_ranks(costs);
  plan.memory_bytes_per_rank = peak_memory_bytes();
  plan.machine_memory_bytes = machine_memory_bytes();
  return plan;
}

/// A text about the accuracy of the mean.
std::string accuracy_text(const Plan& plan) {
  if (!plan.is_sample()) return "all rays were solved";
  if (!plan.measured.relative_standard_error) return "imprecise";  // fewer than RayCosts::fewest_nodes
  return fmt::format("standard error {:.0f} %", 100 * *plan.measured.relative_standard_error);
}

void print_plan(const Options& options, const Plan& plan) {
  const auto& m = plan.measured;
  print_result("time      {} on {} rank{}{}; all times here are of idle cores, shared ones take longer\n",
               duration(plan.wall_seconds), plan.ranks, plan.ranks == 1 ? "" : "s",
               options.ranks ? "" : ", the processor cores of this machine");
  if (!plan.check_seconds)
    print_result(
        "check     of validation.check_probes probes in phynness run; its time is not predicted and not limited\n");
  else if (*plan.check_seconds > 0)
    print_result("check     at most {} more in phynness run (validation.check_probes)\n",
                 duration(*plan.check_seconds));
  print_result("then      {}validate {} probes in phynness run: about {} more\n",
               plan.calibration_rays > 0 ? fmt::format("calibrate {} rays and ", plan.calibration_rays) : "",
               plan.probes, duration(plan.calibrate_seconds + plan.validate_seconds));
  if (plan.reduce_seconds)
    print_result(
        "body      of several tools: reduce about {}; if its errors are large, larger bodies follow, each in as long "
        "as all before; calibrate body about {}\n",
        duration(*plan.reduce_seconds), duration(*plan.calibrate_body_seconds));
  print_result(
      "all       about {} in phynness run, without train{}\n",
      duration(plan.wall_seconds + plan.check_seconds.value_or(0) + plan.calibrate_seconds + plan.validate_seconds +
               plan.reduce_seconds.value_or(0) + plan.calibrate_body_seconds.value_or(0)),
      plan.check_seconds ? "" : " and check");
  print_result("rays      {} to solve, {:.2g} s each: the mean of {} at {} node{} ({}), at most {:.2g} s\n",
               plan.rays_requested, m.seconds_per_ray, m.rays, m.nodes, m.nodes == 1 ? "" : "s", accuracy_text(plan),
               m.seconds_longest_ray);
  if (plan.points_at_rest > 0)
    print_result("elsewhere {} points with the linear response at rest: {}, by one rank\n", plan.points_at_rest,
                 duration(m.at_rest_seconds));
  print_result("memory    {} per rank of precompute, {} in all{}; this machine has {}\n",
               bytes(plan.memory_bytes_per_rank), bytes(plan.ranks * plan.memory_bytes_per_rank),
               plan.check_memory_bytes > 0 ? fmt::format("; about {} for check", bytes(plan.check_memory_bytes)) : "",
               bytes(plan.machine_memory_bytes));
  print_result("database  {} before compression, and {} of logs until it is packed\n", bytes(plan.database_bytes),
               bytes(plan.log_bytes));
  print_result("useful    up to {} ranks; of more, over half of the time is lost\n", plan.ranks_of_use);
}

void run(const Options& options) {
  const SolverSession session;
  const auto loaded = load_scene(options.scene);
  print_choice_note(loaded);
  install_stop_handler();  // a signal before ends the program: there is nothing to keep
  const Plan plan = make_plan(options, loaded);
  print_plan(options, plan);
  print_cells_across(loaded);
  if (plan.ranks * plan.memory_bytes_per_rank > plan.machine_memory_bytes)
    message("warning: {} ranks do not fit into the memory of this machine, but {} ranks do\n", plan.ranks,
            std::floor(plan.machine_memory_bytes / plan.memory_bytes_per_rank));
  if (plan.is_sample() && plan.measured.relative_standard_error.value_or(0) > acceptable_error)
    message("note: the costs of the rays differ much; --rays {} would halve the standard error\n",
            4 * plan.measured.rays);
  write_json(options.json_file, figures(plan));
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "plan",
      "Predict time, memory and sizes of precompute, and the useful number of ranks, from a sample of solved rays",
      run);
  add_scene(command, options.scene);
  add_count(command, "--ranks", options.ranks, 1, 1000000,
            "number of MPI processes of the plan (default: the processor cores of this machine)");
  add_count(command, "--rays", options.rays, 1, 100000, "number of rays to solve")->capture_default_str();
  add_count(command, "--seed", options.seed, 0, largest_seed, "seed of the random choice of rays")
      ->capture_default_str();
  add_json(command, options.json_file, "write the plan as JSON");
}

}  // namespace phynness::cli::plan_command
