#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/training/families.hpp>
#include <phynness/validation/tuning.hpp>

#include "commands.hpp"

namespace phynness::cli::tune_command {
namespace {

struct Options {
  std::filesystem::path scene, database, output;
  OptionalPath json_file;
  std::optional<std::string> max_error, max_time;
  /// The seed differs from that of phynness validate, whose probes therefore test the choice independently.
  std::int64_t probes = 400, seed = 2;
};

void print_table(const TuningReport& report, const std::optional<std::size_t>& chosen) {
  print_result("{:<36} {:>13} {:>13} {:>13} {:>6} {:>7} {:>6}\n", "", "force inside", "displ. inside", "displ. beyond",
               "force", "deform.", "memory");
  print_result("{:<36} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>6}\n", "model, errors of eq. (17) in %",
               "mean", "p95", "mean", "p95", "mean", "p95", "us", "us", "MB");
  const auto errors = [&](const PredictorErrors& e) {
    for (const auto& statistics : {e.inside.force, e.inside.displacement, e.outside.displacement})
      print_result(" {:6.2f} {:6.2f}", 100 * statistics.mean, 100 * statistics.p95);
  };
  for (std::size_t i = 0; i < report.models.size(); ++i) {
    const auto& m = report.models[i];
    print_result("{} {:<34}", chosen == i ? '>' : m.on_front ? '*' : ' ', m.candidate.name);
    errors(m.errors);
    print_result(" {:6.2f} {:7.1f} {:6.2f}\n", m.speed.force_us, m.speed.deformation_us, m.memory_bytes / 1e6);
  }
  print_result("  {:<34}", "(linear predictor)");
  errors(report.linear);
  print_result("\n> chosen; * no other model is better in error (mean), time and memory\n");
}

TuningLimits limits_of(const Options& options) {
  TuningLimits limits;
  limits.error = limit_of(options.max_error, "--max-error", {{"%", 0.01}, {"", 1}}, "2%");
  limits.deformation_us = limit_of(options.max_time, "--max-time", {{"us", 1}, {"ms", 1e3}, {"s", 1e6}}, "20us");
  return limits;
}

/// Shows a progress line for each kind of work.
TuningProgress shown_progress() {
  return [progress = std::make_shared<std::optional<Progress>>(), current_work = std::string()](
             const std::string& what, std::int64_t done, std::int64_t total) mutable {
    if (what != current_work) progress->emplace(current_work = what, what == "solve probes" ? "rays" : "nodes");
    (*progress)->update(done, total);
  };
}

void print(const Scene& scene, const TuningReport& report, const TuningChoice& choice) {
  print_result("{}, {}, K/mu = {:.4g}, R = {:.4g} mm: {} probes at {} nodes, {} failed; {}\n", scene.title,
               name(scene.solver.element), scene.material.bulk_to_shear(), 1e3 * scene.probe.max_displacement_m,
               report.probes, report.nodes.size(), report.failed, duration(report.seconds));
  print_table(report, choice.chosen);
  for (const auto& reason : report.left_out) message("note: not trained: {}\n", reason);
  if (2 * report.failed > report.probes)
    message("warning: {} of {} probes failed; errors are those of the other probes\n", report.failed, report.probes);
}

json as_json(const TuningReport& report, const TuningChoice& choice) {
  json models = json::array();
  for (const auto& m : report.models)
    models.push_back(record("name", m.candidate.name, "family", name(m.model.family), "inside",
                            figures(m.errors.inside), "outside", figures(m.errors.outside), "force_us",
                            m.speed.force_us, "deformation_us", m.speed.deformation_us, "memory_bytes", m.memory_bytes,
                            "model_text_bytes", m.text_bytes, "training_s", m.training_s, "on_front", m.on_front));
  json out = record("models", models, "chosen", nullptr, "missed", choice.missed, "probes", report.probes, "failed",
                    report.failed, "nodes", report.nodes, "linear", figures(report.linear));
  if (choice.chosen) out["chosen"] = report.models[*choice.chosen].candidate.name;
  return out;
}

void run(const Options& options) {
  const TuningLimits limits = limits_of(options);
  const SolverSession session;
  const Scene scene = open_scene(options.scene);
  const auto database = open_database(scene, options.database);
  end_at_signals("tuning was interrupted\n  remedy: run the same command again; nothing was written\n");
  TuningReport report =
      tune(session, scene, database, options.probes, static_cast<std::uint64_t>(options.seed), shown_progress());
  install_stop_handler();  // the outputs are written
  mark_front(report.models);
  const auto choice = choose_model(report.models, limits);
  print(scene, report, choice);
  const auto write_model = [&] {
    if (!choice.chosen) return;
    write_model_dir(options.output, report.models[*choice.chosen].model, database.header().mesh);
    print_result("{} -> {}\n", report.models[*choice.chosen].candidate.name, options.output.string());
    print_missing_bounds(report.models[*choice.chosen].model);
  };
  write_each({write_model, [&] { write_json(options.json_file, as_json(report, choice)); }});
  if (!choice.chosen)
    throw failure("no model meets the limits", choice.missed,
                  "relax the limits, or precompute more directions; no model was written");
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "tune", "Train families and sizes, measure error, time and memory, write the model that meets the limits",
      run);
  add_scene(command, options.scene, "scene from which the database was made");
  add_database(command, options.database, "database.h5 of phynness precompute");
  add_output(command, options.output, PathKind::model, "model directory to write");
  command.add_option("--max-error", options.max_error,
                     "largest mean error (17) of force and displacement inside the trained range, such as 2%");
  command.add_option("--max-time", options.max_time,
                     "longest time of one deformation of all output nodes on this machine, such as 20us");
  add_count(command, "--probes", options.probes, 1, 1'000'000, "number of new solves by which all models are measured")
      ->capture_default_str();
  add_count(command, "--seed", options.seed, 0, largest_seed, "seed of the random probes")->capture_default_str();
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::tune_command
