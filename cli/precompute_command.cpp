#include <fmt/core.h>

#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>

#include "commands.hpp"
#include "console.hpp"

namespace phynness::cli {
namespace {

struct Options {
  std::filesystem::path scene, output;
  std::optional<std::filesystem::path> json_file;
  bool resume = false;
};

void run(const Options& options) {
  refuse_overwriting(options.output, {options.scene});
  if (options.json_file) refuse_overwriting(*options.json_file, {options.scene, options.output});
  install_stop_handler();
  const SolverSession session;
  const bool first = session.rank() == 0;
  LoadedScene loaded;
  session.together([&] { loaded = load_scene(options.scene, !first); });
  if (first && options.resume && std::filesystem::exists(options.output)) {
    const auto found = database_progress(options.output);
    for (const auto& damage : found.damage)
      fmt::print(stderr, "warning: {}: {}; {} dropped, their rays will be solved again\n",
                 damage.log.string(), damage.reason, bytes(static_cast<double>(damage.dropped_bytes)));
    fmt::print(stderr, "note: resuming with {} of {} rays\n", found.rays_logged, found.rays_total);
  }
  PrecomputeReport report;
  {
    Progress progress("precompute", "rays");
    report = precompute(
        session, loaded.scene, loaded.mesh, loaded.sets, options.output, options.resume,
        [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
  }
  if (report.interrupted)
    throw failure("interrupted", fmt::format("{} rays finished and kept", report.rays + report.rays_resumed),
                  "go on with --resume");
  if (!first) return;
  const auto size = std::filesystem::file_size(options.output);
  const auto solved = std::max<std::int64_t>(1, report.increments_solved);
  fmt::print(
      "{} active nodes, {} rays ({} resumed), {} increments, {} failed ({:.2f} %), {:.2f} Newton iterations "
      "each\n",
      loaded.sets.active.size(), report.rays + report.rays_resumed, report.rays_resumed, report.increments,
      report.failed,
      100.0 * static_cast<double>(report.failed) / std::max(1.0, static_cast<double>(report.increments)),
      static_cast<double>(report.iterations) / static_cast<double>(solved));
  if (report.rays_mirrored > 0)
    fmt::print("{} rays ({:.0f} %) are mirror images of these and cost nothing\n", report.rays_mirrored,
               100.0 * static_cast<double>(report.rays_mirrored) /
                   static_cast<double>(report.rays + report.rays_resumed + report.rays_mirrored));
  fmt::print("{} on {} rank{}, {:.1f} core-ms per increment\n", duration(report.wall_seconds), session.size(),
             session.size() == 1 ? "" : "s", 1e3 * report.core_seconds / static_cast<double>(solved));
  if (report.failed == report.increments && report.increments > 0)
    throw failure("no increment converged", std::to_string(report.increments) + " increments",
                  "phynness info " + options.output.string() +
                      " says why; a smaller displacement, more increments or "
                      "another element may help");
  if (report.failed > report.increments / 100)
    fmt::print(stderr,
               "warning: {} increments failed and will not be trained on; phynness info {} says why\n",
               report.failed, options.output.string());
  fmt::print("database {} -> {}\n", bytes(static_cast<double>(size)), options.output.string());
  write_json(options.json_file, {{"active_nodes", loaded.sets.active.size()},
                                 {"rays", report.rays + report.rays_resumed},
                                 {"rays_resumed", report.rays_resumed},
                                 {"rays_mirrored", report.rays_mirrored},
                                 {"increments", report.increments},
                                 {"failed", report.failed},
                                 {"newton_iterations", report.iterations},
                                 {"ranks", session.size()},
                                 {"wall_seconds", report.wall_seconds},
                                 {"core_seconds", report.core_seconds},
                                 {"database_bytes", size}});
}

}  // namespace

void add_precompute_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(
      "precompute",
      "Solve every probe of the scene with finite elements -> database.h5\n(in parallel: mpirun -n 8 "
      "phynness precompute ...)");
  command->add_option("SCENE", options->scene, "scene file (formats/scene.md)")->required();
  command->add_option("-o,--output", options->output, "database to write (formats/database.md)")->required();
  command->add_flag("--resume", options->resume, "go on with an unfinished database");
  command->add_option("--json", options->json_file, "write the figures for machines");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli
