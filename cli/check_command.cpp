#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/formats/locking.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/formats/figures.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "output_places.hpp"
#include "streams.hpp"

namespace phynness::cli::check_command {
namespace {

struct Options {
  std::filesystem::path scene;
  DiscretizationOptions check;
  std::optional<std::filesystem::path> json_file;
};

constexpr Variant references[] = {Variant::taylor_hood, Variant::half_size};

std::string in_words(const Scene& scene, const DiscretizationReport& report, Variant v) {
  if (v == Variant::taylor_hood) return "taylor-hood elements on the same mesh";
  return fmt::format("{} elements of half the size ({} nodes instead of {})", name(scene.solver.element),
                     report.cost(v).n_nodes, report.cost(Variant::scene).n_nodes);
}

std::string direction_of(const CheckedProbe& probe) {
  const auto& d = probe.direction;
  return fmt::format("node {}, direction {:.3g} {:.3g} {:.3g}", probe.node, d[0], d[1], d[2]);
}

/// The limit that --seconds needs for all probes, rounded up to two digits.
std::string sufficient_limit(const DiscretizationReport& report) {
  const double seconds = std::max(1.0, 1.1 * report.sufficient_s),
               unit = std::pow(10, std::floor(std::log10(seconds)) - 1);
  return fmt::format("--seconds {:.0f}", std::ceil(unit * std::ceil(seconds / unit)));
}

void print_left_out(const DiscretizationReport& report, Variant v) {
  const auto& cost = report.cost(v);
  if (!cost.possible) {
    print_result("  not compared: {}\n", cost.left_out);
  } else if (!cost.left_out.empty()) {
    print_result("  {} for their time: about {} are predicted for each; {} would be enough for all\n",
                 std::ranges::any_of(report.probes, [&](const auto& probe) { return !probe.of(v).status.empty(); })
                     ? "further probes were left out"
                     : "no probe was compared",
                 duration(cost.predicted_s), sufficient_limit(report));
  }
}

/// Prints the probes that failed before the largest displacement, with the reason.
std::int64_t print_failed(const DiscretizationReport& report, Variant v) {
  std::int64_t failed = 0;
  for (const auto& probe : report.probes) {
    const auto& forces = probe.of(v);
    for (std::size_t i = 0; i < forces.status.size(); ++i) {
      if (forces.converged(i)) continue;
      print_result("  {}: failed from |d| = {:.4g} mm on ({})\n", direction_of(probe), 1e3 * report.depth_m[i],
                   name(forces.status[i]));
      ++failed;
      break;
    }
  }
  return failed;
}

void print_comparison(const Scene& scene, const DiscretizationReport& report, Variant v) {
  print_result("forces against {}\n", in_words(scene, report, v));
  for (std::size_t i = 0; i < report.depth_m.size(); ++i) {
    const auto ratios = report.ratios(v, i);
    if (ratios.n == 0) continue;
    print_result("  |d| = {:6.4g} mm  {:24} {:.3g} times in the median of {} probe{}, {:.3g} to {:.3g}\n",
                 1e3 * report.depth_m[i], ratio_in_words(ratios.median), ratios.median, ratios.n,
                 ratios.n == 1 ? "" : "s", ratios.min, ratios.max);
  }
  print_failed(report, v);
  print_left_out(report, v);
}

void print(const Scene& scene, const DiscretizationReport& report) {
  print_result("{} ({}), {}, K/mu = {:.4g}: {} probes, patch radius {:.4g} mm ({:.1f} edges), |d| to {:.4g} mm\n",
               scene.title.empty() ? "scene" : scene.title, name(scene.material.law), name(scene.solver.element),
               scene.material.bulk_to_shear(), report.probes.size(), 1e3 * report.tool_radius_m, report.tool_edges,
               1e3 * scene.probe.max_displacement_m);
  if (report.patch_for_node)
    message(
        "note: the scene displaces single nodes, whose force depends on element and mesh even without locking; "
        "patches of {:.4g} mm are compared instead\n",
        1e3 * report.tool_radius_m);
  if (print_failed(report, Variant::scene) > 0) print_result("  these are probes of the scene itself\n");
  for (const auto v : references) print_comparison(scene, report, v);
  print_result("{}\n", duration(report.seconds));
}

json as_json(const Scene& scene, const DiscretizationReport& report) {
  Scene checked = scene;
  checked.probe.kind = ProbeKind::patch;
  const double expected = expected_force_ratio(checked, report.mean_edge_m);
  json out{{"element", name(scene.solver.element)},
           {"bulk_to_shear", scene.material.bulk_to_shear()},
           {"expected_ratio", expected > 1 ? json(expected) : json(nullptr)}};
  out.update(figures(report));
  return out;
}

/// @throws Error (failure) if some requested figures are missing
void refuse_nothing(const Options& options, const DiscretizationReport& report) {
  if (report.interrupted)
    throw failure("check was interrupted; the figures above are those of the finished part",
                  fmt::format("{} of {} probes", report.probes.size(), options.check.probes), "run it again");
  if (report.probes.empty())
    throw failure("not one probe of the scene was solved in the given time",
                  fmt::format("--seconds {:g}", options.check.seconds),
                  fmt::format("allow {}, or use a coarser mesh", sufficient_limit(report)));
  std::int64_t compared = 0;
  for (const auto v : references)
    for (std::size_t i = 0; i < report.depth_m.size(); ++i) compared += report.ratios(v, i).n;
  if (compared > 0) return;
  if (std::ranges::none_of(references, [&](Variant v) { return report.cost(v).left_out == "time"; }))
    throw failure("nothing could be compared", "all solves failed", "reduce max_displacement_m");
  throw failure("nothing could be compared in the given time", fmt::format("--seconds {:g}", options.check.seconds),
                fmt::format("allow {}, or use a coarser mesh", sufficient_limit(report)));
}

void run(const Options& options) {
  const SolverSession session;
  const auto loaded = load_scene(options.scene);
  install_stop_handler();
  DiscretizationReport report;
  {
    Progress progress("check", "rays");
    report = check_discretization(
        loaded.scene, loaded.mesh, loaded.sets, options.check,
        [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
  }
  print(loaded.scene, report);
  write_each({[&] { write_json(options.json_file, as_json(loaded.scene, report)); },
              [&] { refuse_nothing(options, report); }});
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("check", "Compare element and mesh of a scene with better ones at a few probes");
  add_path(*command, "SCENE", options->scene, InputKind::whole, "scene file")->required();
  command->add_option("--probes", options->check.probes, "number of probes, each at another node")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command
      ->add_option("--seconds", options->check.seconds,
                   "time for all; the cheaper comparison comes first and uses at most half of it, each probe its share")
      ->check(finite_range(1, 1e7))
      ->capture_default_str();
  add_path(*command, "--json", options->json_file, OutputKind::file, "write the figures as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::check_command
