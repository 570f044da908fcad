#include <algorithm>
#include <map>
#include <phynness/formats/text_file.hpp>
#include <phynness/pages/report.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/training/families.hpp>
#include <phynness/tuning/tuning.hpp>

#include "commands.hpp"

namespace phynness::cli::tune_command {
namespace {

struct Options {
  std::filesystem::path scene, database, output;
  OptionalPath json_file, plot_file;
  std::optional<std::string> max_error, max_time, max_size;
  std::string error_by = "mean";
  bool spacings = false;
  /// Another seed than that of phynness validate, whose probes then test the choice independently.
  std::int64_t probes = 400, seed = 2;
};

const std::map<ErrorStatistic, std::string> statistic_names{
    {ErrorStatistic::mean, "mean"}, {ErrorStatistic::median, "median"}, {ErrorStatistic::p95, "p95"}};

void print_table(const TuningReport& report, const std::optional<std::size_t>& chosen, ErrorStatistic statistic) {
  const bool by_median = statistic == ErrorStatistic::median;
  const char* middle = by_median ? "median" : "mean";
  print_result("{:<36} {:>13} {:>13} {:>13} {:>6} {:>7} {:>6}\n", "", "force inside", "displ. inside", "displ. beyond",
               "force", "deform.", "memory");
  print_result("{:<36} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>6}\n", "model, errors of eq. (17) in %",
               middle, "p95", middle, "p95", middle, "p95", "us", "us", "MB");
  const auto errors = [&](const PredictorErrors& e) {
    for (const auto& some : {e.inside.force, e.inside.displacement, e.outside.displacement})
      print_result(" {:6.2f} {:6.2f}", 100 * (by_median ? some.median : some.mean), 100 * some.p95);
  };
  for (std::size_t i = 0; i < report.models.size(); ++i) {
    const auto& m = report.models[i];
    print_result("{} {:<34}", chosen == i ? '>' : m.on_front ? '*' : ' ', m.candidate.name);
    errors(m.errors);
    print_result(" {:6.2f} {:7.1f} {:6.2f}\n", m.speed.force_us, m.speed.deformation_us, m.memory_bytes / 1e6);
  }
  print_result("  {:<34}", "(linear predictor)");
  errors(report.linear);
  print_result("\n> chosen; * no other model is better in error ({}), time and memory\n",
               statistic_names.at(statistic));
}

/// A page with two charts: error against time and error against memory.
void plot(const std::filesystem::path& file, const TuningReport& report, const std::string& title,
          const std::optional<std::size_t>& chosen, ErrorStatistic statistic) {
  using report::Curve;
  const auto curves = [&](auto&& abscissa) {
    std::vector<Curve> all;
    for (const auto* each : every_family())
      all.push_back({name(each->family), "points", static_cast<int>(all.size()) + 3, {}});
    Curve front{"on the front", "joined", 2, {}}, best{"chosen", "points", 1, {}};
    for (std::size_t i = 0; i < report.models.size(); ++i) {
      const auto& m = report.models[i];
      const std::pair<double, double> at{abscissa(m), 100 * m.error(statistic)};
      for (std::size_t f = 0; f < all.size(); ++f)
        if (all[f].title == name(m.candidate.spec.family)) all[f].at.push_back(at);
      if (m.on_front) front.at.push_back(at);
      if (chosen == i) best.at.push_back(at);
    }
    all.push_back(front);
    all.push_back(best);
    for (auto& curve : all) std::sort(curve.at.begin(), curve.at.end());
    return all;
  };
  const auto error = fmt::format("larger {} error of force and displacement, %", statistic_names.at(statistic));
  const json logarithmic = record("log_x", true, "log_y", true);
  const json charts{report::chart("Error against time", "one deformation, us", error,
                                  curves([](const auto& m) { return m.speed.deformation_us; }), logarithmic),
                    report::chart("Error against memory", "memory, MB", error,
                                  curves([](const auto& m) { return m.memory_bytes / 1e6; }), logarithmic)};
  write_text_file(file, report::page(title, {report::section("", {record("charts", charts)})}));
  print_result("plot: {}\n", file.string());
}

json sizes(const TrainingSpec& spec) {
  json found;
  for (const auto& [key, number] : operations(spec.family).sizes) found[key] = spec.*number;
  return found;
}

TuningLimits limits_of(const Options& options) {
  TuningLimits limits;
  limits.error = limit_of(options.max_error, "--max-error", {{"%", 0.01}, {"", 1}}, "2%");
  limits.deformation_us = limit_of(options.max_time, "--max-time", {{"us", 1}, {"ms", 1e3}, {"s", 1e6}}, "20us");
  limits.memory_bytes = limit_of(options.max_size, "--max-size", {{"B", 1}, {"kB", 1e3}, {"MB", 1e6}}, "1MB");
  for (const auto& [statistic, name] : statistic_names)
    if (name == options.error_by) limits.statistic = statistic;
  return limits;
}

/// A line of progress for each work.
TuningProgress shown_progress() {
  return [progress = std::make_shared<std::optional<Progress>>(), doing = std::string()](
             const std::string& what, std::int64_t done, std::int64_t total) mutable {
    if (what != doing) progress->emplace(doing = what, what == "solve probes" ? "rays" : "nodes");
    (*progress)->update(done, total);
  };
}

void print(const std::vector<SpacingRow>& rows, const TuningLimits& limits) {
  if (rows.empty()) return;
  print_result(
      "\n{:>10} {:>7} {:>9} {:>11}  {:>22}  {:>15}\n{:>10} {:>7} {:>9} {:>11}  {:>6} {:>7} {:>7}  {:>7} {:>7}\n",
      "spacing,", "", "left out,", "of these", "force between, %", "nearest point", "mm", "points", "nodes",
      "unanswered", "mean", "p95", "max", "mean", "p95");
  for (const auto& row : rows)
    print_result("{:>10.3g} {:>7} {:>9} {:>11}  {:>6.2f} {:>7.2f} {:>7.2f}  {:>7.2f} {:>7.2f}\n", 1e3 * row.spacing_m,
                 row.points, row.left_out, row.unanswered, 100 * row.between.mean, 100 * row.between.p95,
                 100 * row.between.max, 100 * row.nearest.mean, 100 * row.nearest.p95);
  print_result("errors at the nodes left out, over the largest force of the node; their rays are in the database\n");
  if (!limits.error) return;
  if (const auto* row = sparsest(rows, *limits.error, limits.statistic))
    print_result("active = {{ spacing_m = {:.3g}, within = ... }} has a {} error of at most {:.3g} % with {} points\n",
                 row->spacing_m, statistic_names.at(limits.statistic), 100 * *limits.error, row->points);
  else
    print_result("no spacing has a {} error of at most {:.3g} %: keep all points, or use a wider tool\n",
                 statistic_names.at(limits.statistic), 100 * *limits.error);
}

void check_plot(const Options& options) {
  if (options.plot_file) report::require_page();
  if (options.plot_file && options.plot_file->extension() != ".html")
    throw input_error("the format of the plot is unknown", options.plot_file->string(),
                      "give --plot a name that ends in .html");
}

void print(const Scene& scene, const TuningReport& report, const TuningChoice& choice, const TuningLimits& limits) {
  print_result("{}, {}, K/mu = {:.4g}, R = {:.4g} mm: {} probes at {} nodes, {} failed; {}\n", scene.title,
               name(scene.solver.element), scene.material.bulk_to_shear(), 1e3 * scene.probe.max_displacement_m,
               report.probes, report.nodes.size(), report.failed, duration(report.seconds));
  print_table(report, choice.chosen, limits.statistic);
  for (const auto& reason : report.left_out) message("note: not trained: {}\n", reason);
  if (2 * report.failed > report.probes)
    message("warning: {} of {} probes failed; errors are those of the other probes\n", report.failed, report.probes);
}

json as_json(const TuningReport& report, const TuningChoice& choice, const TuningLimits& limits,
             const std::vector<SpacingRow>& spacings) {
  json models = json::array();
  for (const auto& m : report.models) {
    json entry = record("name", m.candidate.name, "family", name(m.trained.family), "inside", figures(m.errors.inside),
                        "outside", figures(m.errors.outside), "force_us", m.speed.force_us, "deformation_us",
                        m.speed.deformation_us, "memory_bytes", m.memory_bytes, "model_text_bytes", m.text_bytes,
                        "training_s", m.training_s, "on_front", m.on_front);
    // Linear models have no sizes.
    if (!operations(m.trained.family).sizes.empty()) {
      entry["training"] = sizes(m.trained);
      entry["asked"] = sizes(m.candidate.spec);
    }
    models.push_back(entry);
  }
  json out = record("models", models, "chosen", nullptr, "missed", choice.missed, "error_by",
                    statistic_names.at(limits.statistic), "probes", report.probes, "failed", report.failed, "nodes",
                    report.nodes, "linear", figures(report.linear));
  if (!spacings.empty()) out["spacings"] = figures(spacings);
  if (choice.chosen) out["chosen"] = report.models[*choice.chosen].candidate.name;
  return out;
}

void run(const Options& options) {
  const TuningLimits limits = limits_of(options);
  check_plot(options);
  const SolverSession session;
  const Scene scene = open_scene(options.scene);
  const auto database = open_database(scene, options.database);
  if (database.header().physics_hash != physics_hash(scene))
    throw input_error("the database was solved with equations of an earlier version", options.database.string(),
                      "precompute again");
  end_at_signals("tuning was interrupted\n  remedy: run the same command again; nothing was written\n");
  const auto spacings =
      options.spacings ? compare_spacings(scene, options.database, shown_progress()) : std::vector<SpacingRow>();
  TuningReport report =
      tune(session, scene, database, options.probes, static_cast<std::uint64_t>(options.seed), shown_progress());
  install_stop_handler();  // the outputs are written
  mark_front(report.models, limits.statistic);
  const auto choice = choose_model(report.models, limits);
  print(scene, report, choice, limits);
  print(spacings, limits);
  const auto write_model = [&] {
    if (!choice.chosen) return;
    write_model_dir(options.output, report.models[*choice.chosen].model, database.header().mesh);
    print_result("{} -> {}\n", report.models[*choice.chosen].candidate.name, options.output.string());
  };
  const auto draw = [&] {
    if (!options.plot_file) return;
    plot(*options.plot_file, report,
         fmt::format("{}: {}, K/mu = {:.4g}, {} probes, R = {:.4g} mm", scene.title, name(scene.solver.element),
                     scene.material.bulk_to_shear(), name(scene.probe.kind), 1e3 * scene.probe.max_displacement_m),
         choice.chosen, limits.statistic);
  };
  write_each({write_model, [&] { write_json(options.json_file, as_json(report, choice, limits, spacings)); }, draw});
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
                     "largest error (17) of force and displacement inside the trained range, such as 2%");
  command
      .add_option("--error-by", options.error_by,
                  "statistic of the errors; where a body snaps through, a few probes dominate the mean")
      ->check(CLI::IsMember({"mean", "median", "p95"}))
      ->capture_default_str();
  command.add_option("--max-time", options.max_time,
                     "longest time of one deformation of all output nodes on this machine, such as 20us");
  command.add_option("--max-size", options.max_size, "largest memory of the model in the runtime, such as 1MB");
  add_count(command, "--probes", options.probes, 1, 1'000'000, "number of new solves by which all models are measured")
      ->capture_default_str();
  add_count(command, "--seed", options.seed, 0, largest_seed, "seed of the random probes")->capture_default_str();
  command.add_flag("--spacings", options.spacings,
                   "also leave out points of a round tool, more and more, and measure the forces there: how far apart "
                   "they may be");
  add_path(command, "--plot", options.plot_file, PathKind::file,
           "HTML page with charts of error against time and memory");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::tune_command
