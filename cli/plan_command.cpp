#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/ray_tasks.hpp>
#include <phynness/planning/model_size.hpp>
#include <phynness/planning/ray_sample.hpp>
#include <phynness/planning/run_time.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <thread>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "ray_ends.hpp"
#include "streams.hpp"

namespace phynness::cli::plan_command {
namespace {

/// A relative standard error above this is reported; a plan then has an error of up to twice this value.
constexpr double acceptable_error = 0.125;
/// Of records, read, compressed and written by one core: 44 MB/s for scenes/demo.toml, 21 MB/s for liver_case3.toml.
constexpr double packing_B_per_s = 30e6;

struct Options {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> json_file;
  std::optional<int> ranks;  ///< default: the number of processor cores of this machine
  int rays = 96;
  std::int64_t seed = 1;
};

struct Plan {
  RunCosts costs;
  int ranks = 1;
  std::int64_t rays_recorded = 0, rays_mirrored = 0, rays_measured = 0, nodes_measured = 0;
  std::optional<double> relative_error;   ///< RaySample::relative_error() of a sample that is large enough
  std::map<Status, std::int64_t> states;  ///< measured increments by outcome
  double wall_s = 0, log_bytes = 0, database_bytes = 0, memory_bytes = 0, machine_memory_bytes = 0;
  ModelSize model;
  EndSummary ends;  ///< of the measured rays

  bool is_sample() const { return rays_measured < costs.rays; }
};

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

std::vector<RayChoice> choose(const DatabaseHeader& header, const std::vector<char>& requested,
                              const Options& options) {
  const auto points = [&](const std::vector<std::int32_t>& nodes) {
    Points x(static_cast<Eigen::Index>(nodes.size()), 3);
    for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = header.mesh.nodes.row(nodes[static_cast<std::size_t>(i)]);
    return x;
  };
  auto chosen = choose_rays(points(header.sets.active), points(header.sets.fixed), requested, header.directions.size(),
                            static_cast<std::size_t>(options.rays), static_cast<std::uint64_t>(options.seed));
  if (chosen.empty())
    throw input_error("the scene has no rays", options.scene.string(), "check nodes.active and the directions");
  return chosen;
}

/// Solves the sample. The first ray is solved twice, so that costs that occur once per process count as start time.
void measure(const LoadedScene& loaded, const DatabaseHeader& header, const std::vector<RayChoice>& chosen,
             Plan& plan) {
  ProbeSolver solver(loaded.scene, loaded.mesh, loaded.sets);
  std::vector<std::pair<std::int32_t, std::int32_t>> which;
  for (const auto& ray : chosen) which.emplace_back(ray.active, ray.direction);
  const auto total = static_cast<std::int64_t>(which.size()) + 1;
  Progress progress("plan", "rays");
  const auto cold = solve_rays(solver, header, {which.front()}, {}, stop_requested);
  progress.update(1, total);
  const auto solved = solve_rays(
      solver, header, which, [&](std::int64_t done) { progress.update(done + 1, total); }, stop_requested);
  if (solved.interrupted || cold.interrupted)
    throw failure("interrupted", fmt::format("{} of {} rays solved", solved.rays.size(), which.size()),
                  "run the command again; fewer --rays take less time");
  const double spent_s = cpu_seconds();
  RaySample sample{chosen, {}};
  std::vector<RayEnd> ends(header.sets.active.size() * header.directions.size(), RayEnd{EndReason::not_requested});
  for (const auto& ray : solved.rays) {
    sample.seconds.push_back(sum(ray.seconds));
    for (const auto status : ray.status) ++plan.states[status];
    ends[static_cast<std::size_t>(ray.active) * header.directions.size() + static_cast<std::size_t>(ray.direction)] =
        ray.end;
  }
  plan.ends = summarize_ends(header, ends);
  plan.relative_error = sample.relative_error();
  plan.rays_measured = static_cast<std::int64_t>(chosen.size());
  plan.nodes_measured = static_cast<std::int64_t>(solved.node_setup_s.size());
  plan.costs.ray_s = sample.mean_ray_seconds();
  plan.costs.longest_s = *std::max_element(sample.seconds.begin(), sample.seconds.end());
  plan.costs.setup_s = sum(solved.node_setup_s) / static_cast<double>(plan.nodes_measured);
  plan.costs.start_s = std::max(0.0, spent_s - sum(sample.seconds) - sample.seconds.front() - sum(solved.node_setup_s) -
                                         solved.node_setup_s.front());
}

Plan make_plan(const Options& options, const LoadedScene& loaded, const DatabaseHeader& header) {
  const auto requested = requested_rays(loaded.scene, loaded.mesh, header);
  Plan plan;
  measure(loaded, header, choose(header, requested, options), plan);
  const auto n_directions = static_cast<std::ptrdiff_t>(header.directions.size());
  for (auto node = requested.begin(); node != requested.end(); node += n_directions) {
    const auto n = std::count(node, node + n_directions, char{1});
    plan.costs.rays += n;
    plan.costs.nodes += n > 0;
  }
  plan.rays_recorded = static_cast<std::int64_t>(rays_left(header, std::vector<char>(requested.size(), 0)).size());
  plan.rays_mirrored = static_cast<std::int64_t>(requested.size()) - plan.rays_recorded;
  plan.log_bytes = static_cast<double>(plan.rays_recorded) * record_bytes(header);
  plan.database_bytes = static_cast<double>(requested.size()) * record_bytes(header);
  plan.costs.packing_s = plan.database_bytes / packing_B_per_s;
  plan.ranks = options.ranks.value_or(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  plan.wall_s = wall_seconds(plan.costs, plan.ranks);
  plan.model = predict_model_size(loaded.scene, header);
  plan.memory_bytes = peak_memory_bytes();
  plan.machine_memory_bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  return plan;
}

void warn_of_states(const Plan& plan) {
  std::int64_t failed = 0, all = 0;
  std::string reasons;
  for (const auto& [status, count] : plan.states) {
    all += count;
    if (static_cast<int>(status) >= 0) continue;  // converged, or beyond the end of its ray
    failed += count;
    reasons += fmt::format("{}{} {} ({})", reasons.empty() ? "" : ", ", count, name(status), meaning(status));
  }
  if (failed > 0) message("warning: {} of {} increments failed: {}\n", failed, all, reasons);
}

/// The accuracy of the mean in words.
std::string trust(const Plan& plan) {
  if (!plan.is_sample()) return "all rays were solved";
  if (plan.relative_error) return fmt::format("standard error {:.0f} %", 100 * *plan.relative_error);
  return "a guess";  // fewer than RaySample::fewest_nodes
}

void print_plan(const Options& options, const Plan& plan) {
  print_result("time      {} on {} rank{}{}\n", duration(plan.wall_s), plan.ranks, plan.ranks == 1 ? "" : "s",
               options.ranks ? "" : ", the processor cores of this machine");
  print_result("rays      {}, {} more by symmetry; {} solved at {} node{}: {:.3g} s each ({}), at most {:.3g} s\n",
               plan.costs.rays, plan.rays_mirrored, plan.rays_measured, plan.nodes_measured,
               plan.nodes_measured == 1 ? "" : "s", plan.costs.ray_s, trust(plan), plan.costs.longest_s);
  print_result("memory    {} per rank, {} in all; this machine has {}\n", bytes(plan.memory_bytes),
               bytes(plan.ranks * plan.memory_bytes), bytes(plan.machine_memory_bytes));
  print_result("database  {} before compression, and {} of logs until it is packed\n", bytes(plan.database_bytes),
               bytes(plan.log_bytes));
  print_result("model     {}, and {} of mesh\n", bytes(plan.model.model_text_bytes), bytes(plan.model.mesh_text_bytes));
  print_result("useful    up to {} ranks; of more, over half of the time is lost\n", ranks_of_use(plan.costs));
}

void print_notes(const Plan& plan) {
  if (plan.ranks * plan.memory_bytes > plan.machine_memory_bytes)
    message("warning: {} ranks do not fit into the memory of this machine, but {} ranks do\n", plan.ranks,
            std::floor(plan.machine_memory_bytes / plan.memory_bytes));
  if (plan.is_sample() && plan.relative_error.value_or(0) > acceptable_error)
    message("note: the costs of the rays differ much; --rays {} would halve the standard error\n",
            4 * plan.rays_measured);
}

json as_json(const Plan& plan, const DatabaseHeader& header, const json& ends) {
  json states = json::object();
  for (const auto& [status, count] : plan.states) states[name(status)] = count;
  const auto& error = plan.relative_error;
  return {{"rays", plan.rays_recorded},
          {"rays_requested", plan.costs.rays},
          {"rays_mirrored", plan.rays_mirrored},
          {"increments", header.magnitudes_m.size()},
          {"measured",
           {{"rays", plan.rays_measured},
            {"nodes", plan.nodes_measured},
            {"seconds_per_ray", plan.costs.ray_s},
            {"seconds_longest_ray", plan.costs.longest_s},
            {"relative_standard_error", error ? json(*error) : json()},
            {"is_guess", plan.is_sample() && !error},
            {"states", states},
            {"start_seconds", plan.costs.start_s},
            {"node_setup_seconds", plan.costs.setup_s}}},
          {"ends", ends},
          {"ranks", plan.ranks},
          {"wall_seconds", plan.wall_s},
          {"core_hours", plan.wall_s * plan.ranks / 3600},
          {"memory_bytes_per_rank", plan.memory_bytes},
          {"machine_memory_bytes", plan.machine_memory_bytes},
          {"database_bytes", plan.database_bytes},
          {"log_bytes", plan.log_bytes},
          {"model_text_bytes", plan.model.model_text_bytes},
          {"mesh_text_bytes", plan.model.mesh_text_bytes},
          {"ranks_of_use", ranks_of_use(plan.costs)}};
}

void run(const Options& options) {
  const SolverSession session;
  const auto loaded = load_scene(options.scene);
  install_stop_handler();  // a signal before ends the program: there is nothing to keep
  const auto header = database_header(loaded.scene, loaded.mesh, loaded.sets);
  const Plan plan = make_plan(options, loaded, header);
  warn_of_states(plan);
  print_plan(options, plan);
  const json ends = tell_ends(header, plan.ends);
  print_notes(plan);
  write_json(options.json_file, as_json(plan, header, ends));
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("plan",
                                     "Predict time, memory and sizes of precompute, and the useful number of ranks, "
                                     "from a sample of solved rays");
  add_path(*command, "SCENE", options->scene, InputKind::whole, "scene file")->required();
  command
      ->add_option("--ranks", options->ranks,
                   "number of MPI processes of the plan (default: the processor cores of this machine)")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--rays", options->rays, "number of rays to solve")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of the random choice of rays")
      ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()))
      ->capture_default_str();
  add_path(*command, "--json", options->json_file, OutputKind::file, "write the plan as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::plan_command
