#include <algorithm>
#include <charconv>
#include <phynness/formats/database_lock.hpp>
#include <phynness/precompute/precompute.hpp>

#include "commands.hpp"

namespace phynness::cli::precompute_command {
namespace {

struct Options {
  std::filesystem::path scene, output, mesh;
  OptionalPath json_file;
  std::string part;
  bool resume = false;
};

/// @throws Error (input) unless the text is i/n with 0 <= i < n
RayPart part_of(const std::string& text) {
  RayPart part;
  const char *position = text.data(), *end = position + text.size();
  const auto first = std::from_chars(position, end, part.index);
  const bool two = first.ec == std::errc{} && first.ptr != end && *first.ptr == '/';
  const auto second = std::from_chars(two ? first.ptr + 1 : end, end, part.count);
  if (!two || second.ec != std::errc{} || second.ptr != end || part.index < 0 || part.index >= part.count)
    throw input_error("there is no such part", "--part " + text,
                      "give i/n with 0 <= i < n, for example --part 0/8 for the first of eight parts");
  return part;
}

/// Lets a database that has a part of the scene's rays grow in a second file, which replaces it at the end.
void redirect_growth(PrecomputeTarget& target, const LoadedScene& loaded) {
  if (!target.resume || !std::filesystem::exists(target.file)) return;
  if (coverage(read_database_header(target.file), database_header(loaded.scene, loaded.mesh, loaded.sets)) !=
      Coverage::part)
    return;
  target.from = target.file;
  target.file += ".grown";
  const auto wanted = database_header(loaded.scene, loaded.mesh, loaded.sets);
  if (std::filesystem::exists(target.file) && coverage(read_database_header(target.file), wanted) != Coverage::same)
    throw input_error("the database began to grow for another scene", target.file.string(),
                      "finish it with that scene, or delete this file and " + target.file.string() + ".log; " +
                          target.from.string() + " is whole");
  declare_output("--output", target.file, PathKind::database);
}

/// Acquires the locks, which processes with parts do not need, and reports existing results.
/// @throws Error (input) if a file is in use or belongs to another scene
std::vector<DatabaseLock> acquire_locks(const PrecomputeTarget& target, const LoadedScene& loaded) {
  const bool is_new = !std::filesystem::exists(target.file) && !std::filesystem::exists(target.file.string() + ".log");
  if (is_new && !target.from.empty())
    message("note: the rays of {} are kept; the scene has more\n", target.from.string());
  else if (is_new && target.resume && !target.part)
    message("note: {} does not exist yet, so that everything is solved\n", target.file.string());
  std::vector<DatabaseLock> locks;
  for (const auto& file : {target.file, target.from}) {
    if (file.empty()) continue;
    if (target.part) {
      DatabaseLock::require_free(file);
      continue;
    }
    locks.emplace_back(file);
    if (!locks.back().warning().empty()) message("warning: {}\n", locks.back().warning());
  }
  if (target.resume && std::filesystem::exists(target.file)) {
    DatabaseWriter::create(target.file, database_header(loaded.scene, loaded.mesh, loaded.sets), true);
    const auto found = database_progress(target.file);
    print_log_damage(found.damage, "are ignored, and their rays will be solved again");
    message("note: resuming; {} of {} rays are already solved\n", found.rays_logged, found.rays_total);
  }
  return locks;
}

json figures(const LoadedScene& loaded, const PrecomputeTarget& target, const PrecomputeReport& report, int n_ranks) {
  json out =
      record("active_nodes", loaded.sets.active.size(), "rays", report.rays + report.rays_found(), "rays_resumed",
             report.rays_resumed, "rays_taken", report.rays_taken, "increments", report.increments, "increments_of_run",
             report.increments_of_run, "failed", report.failed, "increments_after_end", report.after_end,
             "rays_with_library_errors", report.library_errors, "newton_iterations", report.iterations, "ranks",
             n_ranks, "wall_seconds", report.wall_seconds, "setup_seconds", report.setup_seconds, "solve_seconds",
             report.solve_seconds, "pack_seconds", report.pack_seconds, "points_at_rest", loaded.sets.linear.size(),
             "at_rest_seconds", report.at_rest_seconds, "core_seconds", report.core_seconds, "idle_share",
             report.idle_share, "peak_memory_bytes", report.peak_memory_bytes);
  if (target.part)
    out["part"] = target.part->str();
  else
    out["database_bytes"] = std::filesystem::file_size(target.file);
  return out;
}

/// Prints the numbers of solved rays and increments, and the cost.
void print_work(const SolverSession& session, const LoadedScene& loaded, const PrecomputeTarget& target,
                const PrecomputeReport& report) {
  print_result(
      "{} active nodes, {} rays ({} resumed{}), {} increments, {} failed ({:.2f} %), {:.2f} Newton iterations "
      "each\n",
      loaded.sets.active.size(), report.rays + report.rays_found(), report.rays_resumed,
      target.from.empty()
          ? ""
          : fmt::format(", {} taken from {}, {} solved", report.rays_taken, target.from.string(), report.rays_solved),
      report.increments, report.failed,
      100.0 * static_cast<double>(report.failed) / std::max(1.0, static_cast<double>(report.increments)),
      static_cast<double>(report.iterations) / std::max(1.0, static_cast<double>(report.increments)));
  if (report.after_end > 0)
    print_result("{} increments are beyond the ends of their rays and were not solved; phynness info tells where\n",
                 report.after_end);
  print_result("{} on {} rank{}", duration(report.wall_seconds), session.size(), session.size() == 1 ? "" : "s");
  if (report.increments_of_run > 0)
    print_result(", {:.1f} core-ms per increment{}",
                 1e3 * report.core_seconds / static_cast<double>(report.increments_of_run),
                 report.rays_found() > 0 ? fmt::format(" of the {} of this run", report.increments_of_run) : "");
  print_result("\n");
  if (report.at_rest_seconds > 0)
    print_result("{} points elsewhere with the linear response at rest, {}\n", loaded.sets.linear.size(),
                 duration(report.at_rest_seconds));
  print_result("{} of set-up, {} of solving, {} of packing; ranks idle {:.1f} % of solving; peak memory {} per rank\n",
               duration(report.setup_seconds), duration(report.solve_seconds), duration(report.pack_seconds),
               100 * report.idle_share, bytes(report.peak_memory_bytes));
}

/// Notes that a continued database keeps its relaxation, on which its solves do not depend.
void print_kept_relaxation(const std::filesystem::path& database, const Scene& scene) {
  if (!std::filesystem::exists(database)) return;
  const auto header = read_database_header(database);
  if (header.scene_text.empty()) return;
  const auto stored_terms = stored_scene(header).relaxation.terms;
  if (stored_terms.rows() != scene.relaxation.terms.rows() || stored_terms != scene.relaxation.terms)
    message(
        "note: {} keeps the relaxation of the scene with which it was begun; give this scene to train, to reduce "
        "(--scene), and to solve in place of the database\n",
        database.string());
}

void run(const Options& options) {
  PrecomputeTarget target{options.output, options.resume || !options.part.empty(), {}, {}};
  if (!options.part.empty()) target.part = part_of(options.part);
  const SolverSession session;
  const bool rank_zero = session.rank() == 0;
  LoadedScene loaded;
  std::vector<DatabaseLock> locks;
  session.together([&] {
    loaded = load_scene(options.scene, !rank_zero, {}, target.resume ? options.output : std::filesystem::path(),
                        options.mesh);
    if (rank_zero && options.mesh.empty()) print_choice_note(loaded);
    redirect_growth(target, loaded);
    if (rank_zero && target.resume && target.from.empty()) print_kept_relaxation(target.file, loaded.scene);
    if (rank_zero) locks = acquire_locks(target, loaded);
  });
  // An earlier signal ends the program, because there are no results yet. mpirun kills its ranks a second after its
  // signal, possibly before they finish their rays, and may kill the first rank before it signals the second.
  const bool reports_stop = session.size() > 1 && session.rank() < 2;
  install_stop_handler(true, reports_stop ? "note: told to stop; finished rays are kept: run the command again with "
                                            "--resume to continue\n"
                                          : nullptr);
  const auto warn = [&](const std::string& text) {
    // The error at the end repeats the text with its remedy.
    if (session.size() > 1)
      message("warning: {}\n  the other ranks finish their present nodes\n", text.substr(0, text.find("\n  remedy: ")));
  };
  const auto report = precompute(session, loaded.scene, loaded.mesh, loaded.sets, target,
                                 Progress(target.part ? "part " + target.part->str() : "precompute", "rays").counter(),
                                 stop_requested, warn, Progress("precompute", "points at rest").counter());
  if (report.interrupted)
    throw failure("interrupted", fmt::format("{} rays are finished and kept", report.rays + report.rays_found()),
                  "run the command again with --resume to continue");
  if (!rank_zero) return;
  if (!target.from.empty() && !target.part) {
    std::error_code code;
    const auto log = target.file.string() + ".solver.log";
    DatabaseWriter::replace(target.file, options.output);
    target.file = options.output;
    std::filesystem::rename(log, target.file.string() + ".solver.log", code);  // there is none without messages
  }
  print_work(session, loaded, target, report);
  if (report.library_errors > 0)
    message("warning: {} rays ended because a library call failed; its messages are in {}\n", report.library_errors,
            target.file.string() + ".solver.log");
  if (report.failed == report.increments && report.increments > 0)
    throw failure("no increment converged", std::to_string(report.increments) + " increments",
                  "try a smaller displacement, more increments or another element" +
                      (target.part ? "" : "; phynness info " + target.file.string() + " --failed lists the reasons"));
  if (report.failed > report.increments / 100)
    message("warning: {} increments failed and will not be used for training{}\n", report.failed,
            target.part ? "" : "; phynness info " + target.file.string() + " --failed lists the reasons");
  if (target.part)
    print_result("part {} is in {}.log; when all are: phynness precompute {} -o {} --resume\n", target.part->str(),
                 target.file.string(), options.scene.string(), options.output.string());
  else
    print_result("database {} -> {}\n", bytes(std::filesystem::file_size(target.file)), target.file.string());
  write_json(options.json_file, figures(loaded, target, report, session.size()));
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "precompute",
                  "Solve every probe of the scene with finite elements -> database.h5\n(in parallel: mpirun -n 8 "
                  "phynness precompute ...)",
                  run);
  add_scene(command, options.scene, "scene file (formats/scene.md)");
  add_made_mesh(command, options.mesh);
  add_output(command, options.output, PathKind::database, "database to write (formats/database.md)");
  command.add_flag("--resume", options.resume,
                   "continue the database OUTPUT, finished or not; it may have fewer active nodes,\ndirections and "
                   "increments than the scene");
  command.add_option("--part", options.part,
                     "i/n: solve only part i = 0 ... n-1 of n, as a task of a job array; a run with\n--resume alone "
                     "then solves what is missing and packs all parts");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::precompute_command
