#include <algorithm>
#include <cmath>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/locking.hpp>

#include "commands.hpp"

namespace phynness::cli::check_command {
namespace {

struct Options {
  std::filesystem::path scene, mesh;
  bool trade = false;
  std::optional<double> seconds;
  std::optional<std::string> max_error;
  DiscretizationOptions check;
  std::optional<std::string> reference;
  OptionalPath json_file;
};

/// The option with twice the estimated time of all comparisons, because a busy machine takes longer, rounded up to two
/// digits.
std::string sufficient_limit(const DiscretizationReport& report) {
  const double seconds = std::max(1.0, 2 * report.all_sufficient_s()),
               unit = std::pow(10, std::floor(std::log10(seconds)) - 1);
  return fmt::format("--seconds {:.0f}", std::ceil(unit * std::ceil(seconds / unit)));
}

/// Prints the probes that failed before the largest displacement, with the reason.
void print_failed(const DiscretizationReport& report, const char* solution, VariantForces CheckedProbe::*of) {
  for (const auto& probe : report.probes) {
    const auto& forces = probe.*of;
    std::size_t i = 0;
    while (i < forces.status.size() && forces.converged(i)) ++i;
    if (i == forces.status.size()) continue;
    const auto& d = probe.direction;
    print_result("  node {}, direction {:.3g} {:.3g} {:.3g}: the {} failed from |d| = {:.4g} mm on ({})\n", probe.node,
                 d[0], d[1], d[2], solution, 1e3 * report.depth_m[i], name(forces.status[i]));
  }
}

void print(const Scene& scene, const DiscretizationReport& report) {
  print_result("{} ({}), {}, K/mu = {:.4g}: {} probe{}, patch radius {:.4g} mm ({:.1f} edges), |d| to {:.4g} mm\n",
               scene.title.empty() ? "scene" : scene.title, name(scene.material.law), name(scene.solver.element),
               scene.material.bulk_to_shear(), report.probes.size(), report.probes.size() == 1 ? "" : "s",
               1e3 * report.tool_radius_m, report.tool_edges, 1e3 * scene.probe.max_displacement_m);
  if (report.patch_for_node)
    message(
        "note: the scene displaces single nodes, whose force depends on element and mesh even without locking; "
        "patches of {:.4g} mm are compared instead\n",
        1e3 * report.tool_radius_m);
  const auto distance = report.distance(scene);
  if (distance.probes > 0)
    print_result("  Forces over those of a finer solution at the same displacement (above 1: too stiff):\n");
  for (std::size_t i = 0; i < report.depth_m.size(); ++i) {
    const auto ratios = report.ratios(i);
    if (ratios.n == 0) continue;
    print_result("  |d| = {:6.4g} mm  {:24} {:.3g} times in the median of {} probe{}, {:.3g} to {:.3g}\n",
                 1e3 * report.depth_m[i], ratio_in_words(ratios.median), ratios.median, ratios.n,
                 ratios.n == 1 ? "" : "s", ratios.min, ratios.max);
  }
  if (distance.probes > 0) print_result("  force error: {}\n", distance.sentence());
  if (!report.at_rest.skipped_reason.empty())
    print_result("  not compared at rest: {}\n", report.at_rest.skipped_reason);
  print_failed(report, "scene", &CheckedProbe::own);
  print_failed(report, "finer solution", &CheckedProbe::finer);
  if (report.left_out > 0) print_result("  {} probes were left out for their time\n", report.left_out);
  if (report.left_out > 0 || report.at_rest.sufficient_s > 0)
    print_result("  {} would be enough for all\n", sufficient_limit(report));
  print_result("{}\n", duration(report.seconds));
}

json as_json(const LoadedScene& loaded, const DiscretizationReport& report, int most_probes) {
  const Scene& scene = loaded.scene;
  Scene checked = scene;
  checked.probe.kind = ProbeKind::patch;
  const double expected = expected_force_ratio(checked);
  json out =
      record("element", name(scene.solver.element), "bulk_to_shear", most_locked(scene).bulk_to_shear(),
             "expected_ratio", expected > 1 ? json(expected) : json(nullptr), "mesh_hash", mesh_hash(loaded.mesh),
             "physics_hash", physics_hash(scene), "distance", report.distance(scene), "most_probes", most_probes);
  out.update(figures(report));
  return out;
}

/// @throws Error (failure) if some requested figures are missing
void require_figures(const Options& options, const Scene& scene, const DiscretizationReport& report) {
  if (report.interrupted)
    throw failure("check was interrupted; its figures are those of the finished part",
                  fmt::format("{} of {} probes", report.distance(scene).probes, options.check.probes), "run it again");
  if (report.distance(scene).probes > 0) return;
  if (report.left_out == 0)
    throw failure("nothing could be compared", "all solves failed", "reduce max_displacement_m");
  throw failure(
      "nothing could be compared in the given time", fmt::format("--seconds {:g}", options.check.seconds),
      fmt::format("phynness check SCENE {} compares all {} probes, with fewer --probes it needs less; in phynness "
                  "run, which limits the time, set validation.check_probes; or use a coarser mesh",
                  sufficient_limit(report), options.check.probes));
}

/// The keys of the scene that make this row: the element, "target_nodes = 160" and the like.
std::string scene_keys_of(const TradeRow& row) {
  const auto& mesh = row.scene.mesh;
  std::string lines = fmt::format("element = \"{}\"", name(row.scene.solver.element));
  if (mesh.target_nodes) lines += fmt::format(", target_nodes = {}", *mesh.target_nodes);
  if (mesh.target_size_m) lines += fmt::format(", target_size_m = {:.3g}", *mesh.target_size_m);
  return lines;
}

void print_trade(const Scene& scene, const TradeReport& report, const TradeRow* chosen) {
  const TradeRow& finest = *std::ranges::find_if(report.rows, &TradeRow::is_reference);
  print_result(
      "{} ({}), K/mu = {:.4g}: {} probes of a round tool of {:.4g} mm radius, |d| to {:.4g} mm,\n"
      "against {} elements on {} nodes\n",
      scene.title.empty() ? "scene" : scene.title, name(scene.material.law), scene.material.bulk_to_shear(),
      report.probes, 1e3 * report.tool_radius_m, 1e3 * scene.probe.max_displacement_m,
      name(finest.scene.solver.element), finest.body->mesh.n_nodes());
  print_result("{:<14} {:>6} {:>6}  {:>7} {:>7}  {:>7} {:>8}\n", "", "", "", "force", "off by", "ms of", "database");
  print_result("{:<14} {:>6} {:>6}  {:>7} {:>7}  {:>7} {:>8}\n", "  element", "nodes", "probes", "mean, %", "p95, %",
               "a ray", "core-h");
  for (const auto& row : report.rows) {
    const char mark = chosen == &row ? '>' : row.on_front ? '*' : ' ';
    print_result("{} {:<12} {:>6} ", mark, name(row.scene.solver.element), row.body ? row.body->mesh.n_nodes() : 0);
    if (row.probes == 0 && !(row.is_reference && row.ray_s > 0)) {
      print_result("not compared: {}\n", row.left_out.empty() ? "interrupted" : row.left_out);
      continue;
    }
    const auto percent = [&](double error) { return row.is_reference ? "-" : fmt::format("{:.3g}", 100 * error); };
    print_result("{:>6}  {:>7} {:>7}  {:>7.0f} {:>8.2g}{}\n", row.is_reference ? report.probes : row.probes,
                 percent(row.mean), percent(row.p95), 1e3 * row.ray_s, row.core_hours(),
                 row.is_reference ? "  reference"
                 : row.is_scene   ? "  this scene"
                                  : "");
  }
  std::string legend;
  if (std::ranges::any_of(report.rows, &TradeRow::on_front))
    legend = fmt::format("* no other row is better in error (mean) and core-hours{}; ", chosen ? "; > chosen" : "");
  print_result("\n{}{}\n", legend, duration(report.seconds));
}

void run_trade(const Options& options, const LoadedScene& loaded) {
  const auto error = limit_of(options.max_error, "--max-error", {{"%", 0.01}, {"", 1}}, "5%");
  const auto report = compare_discretizations(loaded.scene, loaded.mesh, loaded.sets, options.check,
                                              Progress("check", "rays").counter(), stop_requested);
  const TradeRow* chosen = error ? chosen_row(report, *error) : nullptr;
  print_trade(loaded.scene, report, chosen);
  if (chosen != nullptr) print_result("> {}\n", scene_keys_of(*chosen));
  json out = figures(report);
  out["chosen"] = chosen != nullptr ? json(chosen - report.rows.data()) : json(nullptr);
  write_json(options.json_file, out);
  if (report.interrupted)
    throw failure(
        "check was interrupted; the rows above are those of the finished part",
        fmt::format("{} of {} rows", std::ranges::count_if(report.rows, [](const auto& row) { return row.probes > 0; }),
                    report.rows.size()),
        "run it again");
  if (error && is_alone(report))
    throw failure("nothing is chosen, because no row was compared beside the scene's own",
                  fmt::format("--seconds {:g}", options.check.seconds), "allow more --seconds, or use a coarser mesh");
  if (error && chosen == nullptr)
    throw failure("no element and mesh of the table meets the limit", "--max-error " + *options.max_error,
                  "more nodes have a smaller error; or relax the limit");
}

void run(const Options& given_options) {
  Options options = given_options;
  options.check.seconds = options.seconds.value_or(options.trade ? 900 : options.check.seconds);
  const SolverSession session;
  const auto loaded = load_scene(options.scene, false, {}, {}, options.mesh);
  options.check.reference = options.reference ? *variant_named(*options.reference) : finer_reference(loaded.scene);
  install_stop_handler();
  if (options.trade) return run_trade(options, loaded);
  const auto report = check_discretization(loaded.scene, loaded.mesh, loaded.sets, options.check,
                                           Progress("check", "rays").counter(), stop_requested);
  print(loaded.scene, report);
  write_each({[&] { write_json(options.json_file, as_json(loaded, report, options.check.probes)); },
              [&] { require_figures(options, loaded.scene, report); }});
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "check", "Estimate the force error of a scene's finite elements by finer ones at a few probes", run);
  add_scene(command, options.scene);
  add_made_mesh(command, options.mesh);
  add_count(command, "--probes", options.check.probes, 1, 10'000,
            "largest number of probes, each at another place; fewer if their errors agree")
      ->capture_default_str();
  add_number(command, "--seconds", options.seconds, 1, 1e7,
             "time limit; a solve that has begun is finished (default: 60; with --trade 900)");
  auto* reference = command
                        .add_option("--reference", options.reference,
                                    "the finer solution (default: taylor-hood where the scene allows it)")
                        ->check(CLI::IsMember({name(Variant::taylor_hood), name(Variant::half_size)}));
  auto* trade = command
                    .add_flag("--trade", options.trade,
                              "compare all elements on meshes of half, the same and twice as many nodes instead: error "
                              "and time in one table")
                    ->excludes(reference);
  command
      .add_option("--max-error", options.max_error,
                  "with --trade: choose the database of the least time with at most this mean error, such as 5%")
      ->needs(trade);
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::check_command
