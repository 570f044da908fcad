#include <fmt/core.h>

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/planning/scaling_curve.hpp>

#include "console.hpp"
#include "plan.hpp"
#include "streams.hpp"

namespace phynness::cli {
namespace {

constexpr double wanted_efficiency = 0.9;
constexpr int most_ranks = 10000;
/// Twice this is the error that a plan may have.
constexpr double acceptable_error = 0.125;

struct Way {
  const char* name;
  const char* key;
  Policy policy;
};

/// The first is what precompute does.
std::vector<Way> ways() {
  return {{"as precompute", "precompute", {Grain::ray, Order::stored, 2, true}},
          {"one by one", "one_by_one", {Grain::ray, Order::stored, 0, false}},
          {"longest first", "longest_first", {Grain::ray, Order::longest_first, 0, false}},
          {"increments", "increments", {Grain::increment, Order::longest_first, 0, false}},
          {"whole nodes", "whole_nodes", {Grain::node, Order::stored, 0, false}}};
}

MachineCosts machine_of(const PlanOptions& options, const PlanBasis& basis) {
  MachineCosts machine;
  machine.launch_s = options.launch_s;
  machine.start_s = options.start_s.value_or(basis.start_s);
  machine.node_setup_s = options.setup_ms ? *options.setup_ms * 1e-3 : basis.node_setup_s;
  machine.fetch_latency_s = 0.5e-6 * options.fetch_us;
  machine.fetch_service_s = 0.5e-6 * options.fetch_us;
  machine.log_create_s = 1e-3 * options.open_ms;
  machine.bandwidth_B_per_s = 1e6 * options.bandwidth_MB_per_s;
  machine.pack_log_open_s = 1e-3 * options.open_ms;
  const auto n_solved = static_cast<double>(basis.work.n_rays());
  const double packed_per_solved = (n_solved + static_cast<double>(basis.rays_mirrored)) / n_solved;
  machine.pack_s_per_ray =
      packed_per_solved *
      (basis.packing.pack_s_per_ray +
       (basis.packing.record_bytes + basis.packing.packed_bytes_per_ray) / machine.bandwidth_B_per_s);
  return machine;
}

json parts(const CoreSeconds& spent) {
  return {{"solving", spent.solving},   {"node_setup", spent.node_setup}, {"start", spent.start},
          {"fetching", spent.fetching}, {"writing", spent.writing},       {"tail", spent.tail},
          {"packing", spent.packing}};
}

std::vector<int> ladder(int ranks) {
  std::vector<int> steps{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, most_ranks, ranks};
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  return steps;
}

/// The same machine where ranks are there already and nobody packs: what the schedule alone is worth.
MachineCosts solving_only(MachineCosts machine) {
  machine.launch_s = machine.start_s = machine.log_create_s = 0;
  machine.pack_log_open_s = machine.pack_s_per_ray = 0;
  return machine;
}

struct Scaling {
  json curve = json::array(), at_wanted = json::object();
  double efficiency = 1;  ///< of precompute on the ranks asked for
  int ranks = 1;          ///< that precompute can use at the wanted efficiency
  std::string limit;      ///< what limits it just beyond
};

/// Simulates all ways and prints the table.
/// @param done  runs so far, for the progress line that both tables share
Scaling scaling(const char* title, const PlanOptions& options, const RayWork& work,
                const MachineCosts& machine, Progress& progress, std::int64_t& done) {
  const auto all = ways();
  const auto steps = ladder(options.ranks);
  const auto total = static_cast<std::int64_t>(2 * all.size() * (steps.size() + 1));
  Scaling result;
  for (const int ranks : steps) result.curve.push_back({{"ranks", ranks}});
  std::vector<std::vector<double>> table(steps.size());
  std::vector<std::string> limits;
  const auto one = simulate(work, machine, all.front().policy, 1);
  for (const auto& way : all) {
    const bool first = &way == &all.front();
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (stop_requested()) throw failure("interrupted", "the simulation is not complete", "start again");
      const auto many = simulate(work, machine, way.policy, steps[i]);
      const double e = efficiency(one, many);
      table[i].push_back(e);
      result.curve[i][way.key] = {{"wall_seconds", many.wall_s},
                                  {"efficiency", e},
                                  {"limited_by", limited_by(one, many)},
                                  {"core_seconds", parts(many.spent)}};
      if (first) limits.push_back(limited_by(one, many));
      if (first && steps[i] == options.ranks) result.efficiency = e;
      progress.update(++done, total);
    }
    const int ranks = ranks_at_efficiency(wanted_efficiency, one, work, machine, way.policy, most_ranks);
    result.at_wanted[way.key] = ranks;
    if (first) {
      result.ranks = ranks;
      result.limit = limited_by(one, simulate(work, machine, way.policy, ranks + 1));
    }
    progress.update(++done, total);
  }
  print_result("\n{}\n{:>6}", title, "ranks");
  for (const auto& way : all) print_result(" {:>13}", way.name);
  print_result("  precompute is limited by\n");
  for (std::size_t i = 0; i < steps.size(); ++i) {
    print_result("{:>6}", steps[i]);
    for (const double e : table[i]) print_result(" {:>13.1f}", 100 * e);
    print_result("  {}\n", limits[i]);
  }
  print_result("{:>6}", "90 %");
  for (const auto& way : all) print_result(" {:>13}", result.at_wanted[way.key].get<int>());
  print_result("  ranks\n");
  return result;
}

void print_states(const PlanBasis& basis) {
  std::int64_t failed = 0, all = 0;
  std::string reasons;
  for (const auto& [status, count] : basis.states) {
    all += count;
    if (status == Status::converged) continue;
    failed += count;
    reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, name(status));
  }
  if (failed > 0) message("warning: {} of {} increments failed: {}\n", failed, all, reasons);
}

/// The prediction in figures.
struct Prediction {
  MachineCosts machine;
  Schedule run;
  double core_hours = 0, database_bytes = 0, log_bytes = 0, longest_s = 0;
};

Prediction predict(const PlanOptions& options, const PlanBasis& basis) {
  Prediction p;
  p.machine = machine_of(options, basis);
  p.run = simulate(basis.work, p.machine, ways().front().policy, options.ranks);
  const auto n_rays = static_cast<double>(basis.work.n_rays());
  p.core_hours = p.run.wall_s * options.ranks / 3600;
  p.database_bytes = basis.packing.header_bytes +
                     (n_rays + static_cast<double>(basis.rays_mirrored)) * basis.packing.packed_bytes_per_ray;
  p.log_bytes = n_rays * basis.packing.record_bytes;
  for (std::size_t ray = 0; ray < basis.work.n_rays(); ++ray)
    p.longest_s = std::max(p.longest_s, basis.work.ray_seconds(ray));
  return p;
}

void print(const PlanOptions& options, const PlanBasis& basis, const Prediction& p) {
  print_states(basis);
  print_result("measured      {} rays of {} at {} nodes: {:.4g} s each{}, {:.4g} s the longest\n",
               basis.rays_measured, basis.rays_requested, basis.nodes_measured,
               basis.work.total_seconds() / static_cast<double>(basis.rays_requested),
               basis.rays_measured < basis.rays_requested
                   ? fmt::format(" (standard error {:.1f} %)", 100 * basis.relative_error)
                   : "",
               p.longest_s);
  if (basis.rays_mirrored > 0)
    print_result("mirrored      {} rays more, which cost nothing\n", basis.rays_mirrored);
  if (basis.relative_error > acceptable_error)
    message("note: costs differ much between rays; --rays {} would halve the standard error\n",
            4 * basis.rays_measured);
  print_result("on {} rank{}\n", options.ranks, options.ranks == 1 ? "" : "s");
  print_result("  wall time   {}: {} to start, {} to pack\n", duration(p.run.wall_s),
               duration(p.machine.launch_s + p.machine.start_s), duration(p.run.wall_s - p.run.solved_s));
  print_result("  core-hours  {:.4g}, of which solving {:.4g}\n", p.core_hours,
               (p.run.spent.solving + p.run.spent.node_setup) / 3600);
  if (basis.memory_bytes) print_result("  memory      {} a rank\n", bytes(*basis.memory_bytes));
  print_result("database      {}, and {} of logs until it is packed\n", bytes(p.database_bytes),
               bytes(p.log_bytes));
  print_result("model         {} and a mesh of {}\n", bytes(basis.model.model_text_bytes),
               bytes(basis.model.mesh_text_bytes));
}

json measured_json(const PlanBasis& basis, const Prediction& p) {
  json states = json::object();
  for (const auto& [status, count] : basis.states) states[name(status)] = count;
  return {{"rays", basis.rays_measured},
          {"nodes", basis.nodes_measured},
          {"seconds_per_ray", basis.work.total_seconds() / static_cast<double>(basis.rays_requested)},
          {"seconds_longest_ray", p.longest_s},
          {"relative_standard_error", basis.relative_error},
          {"states", states},
          {"start_seconds", p.machine.start_s},
          {"node_setup_seconds", p.machine.node_setup_s},
          {"append_seconds_per_ray", basis.packing.append_s_per_ray},
          {"pack_seconds_per_ray", basis.packing.pack_s_per_ray},
          {"record_bytes", basis.packing.record_bytes}};
}

json as_json(const PlanOptions& options, const PlanBasis& basis, const Prediction& p, const Scaling& scale,
             const Scaling& solving) {
  return {{"rays", basis.work.n_rays()},
          {"rays_requested", basis.rays_requested},
          {"rays_mirrored", basis.rays_mirrored},
          {"increments", basis.work.increments},
          {"measured", measured_json(basis, p)},
          {"assumed",
           {{"launch_seconds", p.machine.launch_s},
            {"bandwidth_bytes_per_second", p.machine.bandwidth_B_per_s},
            {"seconds_per_file", p.machine.log_create_s},
            {"fetch_seconds", p.machine.fetch_latency_s + p.machine.fetch_service_s}}},
          {"ranks", options.ranks},
          {"wall_seconds", p.run.wall_s},
          {"core_hours", p.core_hours},
          {"solving_core_seconds", p.run.spent.solving + p.run.spent.node_setup},
          {"efficiency", scale.efficiency},
          {"memory_bytes_per_rank", basis.memory_bytes ? json(*basis.memory_bytes) : json()},
          {"database_bytes", p.database_bytes},
          {"log_bytes", p.log_bytes},
          {"model_text_bytes", basis.model.model_text_bytes},
          {"mesh_text_bytes", basis.model.mesh_text_bytes},
          {"ranks_at_90_percent", scale.at_wanted},
          {"limited_by", scale.limit},
          {"curve", scale.curve},
          {"solving",
           {{"ranks_at_90_percent", solving.at_wanted},
            {"limited_by", solving.limit},
            {"curve", solving.curve}}}};
}

}  // namespace

json report_plan(const PlanOptions& options, const PlanBasis& basis) {
  const Prediction p = predict(options, basis);
  print(options, basis, p);
  Scaling scale, solving;
  {
    Progress progress("simulate", "runs");
    std::int64_t done = 0;
    scale = scaling("efficiency in % (simulated; wall time of precompute on one rank over ranks x wall time)",
                    options, basis.work, p.machine, progress, done);
    solving = scaling("the same without start and packing", options, basis.work, solving_only(p.machine),
                      progress, done);
  }
  print_result(
      "\n{} ranks can be used at 90 % efficiency, beyond the limit is: {}; while solving alone {} ranks, "
      "{}\n",
      scale.ranks, scale.limit, solving.ranks, solving.limit);
  return as_json(options, basis, p, scale, solving);
}

}  // namespace phynness::cli
