#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/planning/ray_sample.hpp>
#include <phynness/planning/scaling_curve.hpp>
#include <thread>

#include "console.hpp"
#include "plan.hpp"
#include "ray_ends.hpp"
#include "streams.hpp"

namespace phynness::cli {
namespace {

/// A number of ranks is useful if their efficiency is at least this.
constexpr double efficiency_of_use = 0.5, high_efficiency = 0.9;
constexpr int most_ranks = 10000;
/// A relative standard error above this is reported; a plan then has an error of up to twice this value.
constexpr double acceptable_error = 0.125;

MachineCosts machine_of(const PlanOptions& options, const PlanBasis& basis) {
  MachineCosts machine;
  machine.launch_s = options.launch_s;
  machine.start_s = options.start_s.value_or(basis.start_s);
  machine.node_setup_s = options.setup_ms ? *options.setup_ms * 1e-3 : basis.node_setup_s;
  machine.fetch_latency_s = 0.5e-6 * options.fetch_us;
  machine.fetch_service_s = 0.5e-6 * options.fetch_us;
  machine.log_create_s = 1e-3 * options.open_ms;
  machine.log_s_per_ray = basis.packing.append_s_per_ray;
  machine.bandwidth_B_per_s = 1e6 * options.bandwidth_MB_per_s;
  machine.pack_log_open_s = 1e-3 * options.open_ms;
  const auto n_solved = static_cast<double>(basis.work.n_rays());
  const double packed_per_solved = (n_solved + static_cast<double>(basis.rays_mirrored)) / n_solved;
  machine.pack_s_per_ray = packed_per_solved * (basis.packing.pack_s_per_ray +
                                                (basis.packing.record_bytes + basis.packing.packed_bytes_per_ray) /
                                                    machine.bandwidth_B_per_s);
  return machine;
}

double memory_of_this_machine() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

struct Point {
  int ranks = 1;
  double wall_s = 0, efficiency = 1;
  Limit limit = Limit::nothing;
  CoreSeconds spent;
};

Point point(const RayWork& work, const MachineCosts& machine, const Schedule& one_rank, int ranks) {
  if (stop_requested()) throw failure("interrupted", "the simulation is not complete", "run the command again");
  const auto run = simulate(work, machine, ranks);
  return {ranks, run.wall_s, efficiency(one_rank, run), limited_by(one_rank, run, work, machine), run.spent};
}

/// All figures of the plan, for text and JSON.
struct Prediction {
  MachineCosts machine;
  int ranks = 1;
  bool ranks_of_this_machine = false;
  Schedule run;
  double efficiency = 1, cpu_s = 0, core_hours = 0;
  double database_bytes = 0, log_bytes = 0, longest_s = 0, seconds_per_ray = 0;
  double machine_memory_bytes = 0;
  bool is_sample = false;
  int ranks_of_use = 1, ranks_at_90_percent = 1;
  Limit limit = Limit::nothing;  ///< for more than ranks_of_use
  std::vector<Point> curve;      ///< only with --table or --json
};

/// CPU time of all ranks without waiting, as precompute reports it.
double cpu_seconds(const PlanBasis& basis, const Prediction& p) {
  const auto n_rays = static_cast<double>(basis.work.n_rays());
  return p.run.spent.solving + p.run.spent.node_setup + p.ranks * p.machine.start_s +
         n_rays * basis.packing.append_s_per_ray +
         (n_rays + static_cast<double>(basis.rays_mirrored)) * basis.packing.pack_s_per_ray;
}

std::vector<Point> curve_of(const PlanBasis& basis, const Prediction& p, const Schedule& one_rank) {
  std::vector<int> steps{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, most_ranks, p.ranks};
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  std::vector<Point> curve;
  for (const int ranks : steps) curve.push_back(point(basis.work, p.machine, one_rank, ranks));
  return curve;
}

Prediction predict(const PlanOptions& options, const PlanBasis& basis) {
  Prediction p;
  p.machine = machine_of(options, basis);
  p.ranks_of_this_machine = !options.ranks;
  p.ranks = options.ranks.value_or(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const auto one_rank = simulate(basis.work, p.machine, 1);
  p.run = simulate(basis.work, p.machine, p.ranks);
  p.efficiency = efficiency(one_rank, p.run);
  p.cpu_s = cpu_seconds(basis, p);
  p.core_hours = p.run.wall_s * p.ranks / 3600;
  const auto n_rays = static_cast<double>(basis.work.n_rays());
  p.database_bytes = basis.packing.header_bytes +
                     (n_rays + static_cast<double>(basis.rays_mirrored)) * basis.packing.packed_bytes_per_ray;
  p.log_bytes = n_rays * basis.packing.record_bytes;
  p.longest_s = basis.work.longest_seconds();
  p.seconds_per_ray = basis.work.total_seconds() / static_cast<double>(basis.rays_requested);
  p.machine_memory_bytes = memory_of_this_machine();
  p.is_sample = basis.rays_measured < basis.rays_requested;
  // No more ranks than rays can work at the same time.
  const int most = static_cast<int>(std::min<std::size_t>(most_ranks, basis.work.n_rays()));
  p.ranks_of_use = ranks_at_efficiency(efficiency_of_use, basis.work, p.machine, most);
  p.ranks_at_90_percent = ranks_at_efficiency(high_efficiency, basis.work, p.machine, most);
  p.limit = point(basis.work, p.machine, one_rank, p.ranks_of_use + 1).limit;
  if (options.table || options.json_file) p.curve = curve_of(basis, p, one_rank);
  return p;
}

std::string words(Limit limit, const Prediction& p, const PlanBasis& basis) {
  switch (limit) {
    case Limit::nothing:
      return "nothing";
    case Limit::start:
      return "the start of the ranks";
    case Limit::node_setup:
      return "nodes that several ranks share, because each of these ranks prepares the node";
    case Limit::fetching:
      return "the counter that distributes the tasks";
    case Limit::writing:
      return "the bandwidth of the file system";
    case Limit::n_rays:
      return fmt::format("the number of rays, {}", basis.work.n_rays());
    case Limit::longest_ray:
      return fmt::format("the longest ray, {}, which one rank solves alone", duration(p.longest_s));
    case Limit::last_rays:
      return "waiting for the last rays";
    case Limit::packing:
      return "packing the database, which one rank does alone";
  }
  return "unknown";
}

void warn_of_states(const PlanBasis& basis) {
  std::int64_t failed = 0, all = 0;
  std::string reasons;
  for (const auto& [status, count] : basis.states) {
    all += count;
    if (static_cast<int>(status) >= 0) continue;  // converged, or beyond the end of its ray
    failed += count;
    reasons += fmt::format("{}{} {} ({})", reasons.empty() ? "" : ", ", count, name(status), meaning(status));
  }
  if (failed > 0) message("warning: {} of {} increments failed: {}\n", failed, all, reasons);
}

/// The accuracy of the figures in words.
std::string trust(const PlanBasis& basis, const Prediction& p) {
  if (!p.is_sample) return fmt::format("The costs of all {} rays are measured", basis.rays_measured);
  if (basis.relative_error)
    return fmt::format("The standard error of the mean cost is {:.0f} %, from a sample of {} rays of {} at {} nodes",
                       100 * *basis.relative_error, basis.rays_measured, basis.rays_requested, basis.nodes_measured);
  return fmt::format("This is a guess from {} ray{} of {} at {} node{}; a standard error needs rays at {} nodes",
                     basis.rays_measured, basis.rays_measured == 1 ? "" : "s", basis.rays_requested,
                     basis.nodes_measured, basis.nodes_measured == 1 ? "" : "s", RaySample::fewest_nodes);
}

void print_answer(const PlanBasis& basis, const Prediction& p) {
  print_result("precompute takes about {} on {} rank{}{}.\n", duration(p.run.wall_s), p.ranks, p.ranks == 1 ? "" : "s",
               p.ranks_of_this_machine ? ", the processor cores of this machine" : "");
  print_result("{}.\nA ray takes {:.3g} s on average, {:.3g} s at most.\n", trust(basis, p), p.seconds_per_ray,
               p.longest_s);
  print_result("  CPU time      {} of all ranks; the job occupies {:.3g} core-hours\n", duration(p.cpu_s),
               p.core_hours);
  if (basis.memory_bytes)
    print_result("  memory        {} per rank, {} in all; this machine has {}\n", bytes(*basis.memory_bytes),
                 bytes(p.ranks * *basis.memory_bytes), bytes(p.machine_memory_bytes));
  print_result("  database      {}, and {} of logs until it is packed\n", bytes(p.database_bytes), bytes(p.log_bytes));
  print_result("  model         {}, and {} of mesh\n", bytes(basis.model.model_text_bytes),
               bytes(basis.model.mesh_text_bytes));
  print_result("  ranks of use  {}: with more ranks over half of their time is lost; up to {} lose less than a tenth\n",
               p.ranks_of_use, p.ranks_at_90_percent);
  print_result("  limit         {}\n", words(p.limit, p, basis));
  if (basis.rays_mirrored > 0)
    print_result("  mirrored      {} further rays are mirror images and need no solve\n", basis.rays_mirrored);
}

void print_notes(const PlanBasis& basis, const Prediction& p) {
  if (basis.memory_bytes && p.ranks * *basis.memory_bytes > p.machine_memory_bytes)
    message("warning: {} ranks do not fit into the memory of this machine, but {} ranks do\n", p.ranks,
            std::floor(p.machine_memory_bytes / *basis.memory_bytes));
  if (basis.relative_error && *basis.relative_error > acceptable_error)
    message("note: the costs of the rays differ much; --rays {} would halve the standard error\n",
            4 * basis.rays_measured);
}

void print_table(const PlanBasis& basis, const Prediction& p) {
  print_result("\n{:>6} {:>15} {:>11}  limited by\n", "ranks", "wall time", "efficiency");
  for (const auto& at : p.curve)
    print_result("{:>6} {:>15} {:>9.1f} %  {}\n", at.ranks, duration(at.wall_s), 100 * at.efficiency,
                 words(at.limit, p, basis));
  print_result("efficiency: wall time on one rank / (ranks x wall time)\n");
}

json parts(const CoreSeconds& spent) {
  return {{"solving", spent.solving},   {"node_setup", spent.node_setup}, {"start", spent.start},
          {"fetching", spent.fetching}, {"writing", spent.writing},       {"tail", spent.tail},
          {"packing", spent.packing}};
}

json measured_json(const PlanBasis& basis, const Prediction& p) {
  json states = json::object();
  for (const auto& [status, count] : basis.states) states[name(status)] = count;
  return {{"rays", basis.rays_measured},
          {"nodes", basis.nodes_measured},
          {"seconds_per_ray", p.seconds_per_ray},
          {"seconds_longest_ray", p.longest_s},
          {"relative_standard_error", basis.relative_error ? json(*basis.relative_error) : json()},
          {"is_guess", p.is_sample && !basis.relative_error},
          {"states", states},
          {"start_seconds", p.machine.start_s},
          {"node_setup_seconds", p.machine.node_setup_s},
          {"append_seconds_per_ray", basis.packing.append_s_per_ray},
          {"pack_seconds_per_ray", basis.packing.pack_s_per_ray},
          {"record_bytes", basis.packing.record_bytes}};
}

json as_json(const PlanBasis& basis, const Prediction& p, const json& ends) {
  json curve = json::array();
  for (const auto& at : p.curve)
    curve.push_back({{"ranks", at.ranks},
                     {"wall_seconds", at.wall_s},
                     {"efficiency", at.efficiency},
                     {"limited_by", name(at.limit)},
                     {"core_seconds", parts(at.spent)}});
  return {{"rays", basis.work.n_rays()},
          {"rays_requested", basis.rays_requested},
          {"rays_mirrored", basis.rays_mirrored},
          {"increments", basis.increments},
          {"measured", measured_json(basis, p)},
          {"ends", ends},
          {"assumed",
           {{"launch_seconds", p.machine.launch_s},
            {"bandwidth_bytes_per_second", p.machine.bandwidth_B_per_s},
            {"seconds_per_file", p.machine.log_create_s},
            {"fetch_seconds", p.machine.fetch_latency_s + p.machine.fetch_service_s}}},
          {"ranks", p.ranks},
          {"tasks", p.run.tasks.size()},
          {"wall_seconds", p.run.wall_s},
          {"cpu_seconds", p.cpu_s},
          {"core_hours", p.core_hours},
          {"solving_core_seconds", p.run.spent.solving + p.run.spent.node_setup},
          {"efficiency", p.efficiency},
          {"memory_bytes_per_rank", basis.memory_bytes ? json(*basis.memory_bytes) : json()},
          {"machine_memory_bytes", p.machine_memory_bytes},
          {"database_bytes", p.database_bytes},
          {"log_bytes", p.log_bytes},
          {"model_text_bytes", basis.model.model_text_bytes},
          {"mesh_text_bytes", basis.model.mesh_text_bytes},
          {"ranks_of_use", p.ranks_of_use},
          {"ranks_at_90_percent", p.ranks_at_90_percent},
          {"limited_by", name(p.limit)},
          {"curve", curve}};
}

}  // namespace

json report_plan(const PlanOptions& options, const PlanBasis& basis) {
  const Prediction p = predict(options, basis);
  warn_of_states(basis);
  print_answer(basis, p);
  const json ends = tell_ends(basis.header, basis.ends);
  print_notes(basis, p);
  if (options.table) print_table(basis, p);
  return as_json(basis, p, ends);
}

}  // namespace phynness::cli
