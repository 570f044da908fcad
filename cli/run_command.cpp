// Runs mesh, precompute, check, train, calibrate, of several tools reduce, validate and view. Each is a separate
// process, so that the parallel stages run under mpirun and training uses threads.
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <phynness/formats/database_lock.hpp>
#include <phynness/pages/pages.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/tools.hpp>
#include <thread>

#include "commands.hpp"
#include "run_stages.hpp"

namespace phynness::cli::run_command {
namespace {

struct Options {
  std::filesystem::path scene, output;
  OptionalPath json_file;
  int ranks = 1;
  bool resume = false;
};

/// Time and output of a stage, for the table at the end.
struct Stage {
  const char* title;
  double seconds;
  std::filesystem::path written;
};

Stage stage(const char* title, const std::filesystem::path& written, std::vector<std::string> arguments, int ranks) {
  const auto start = std::chrono::steady_clock::now();
  message("== {}\n", title);
  run_child(title, std::move(arguments), ranks, title != std::string_view("validate"));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  // A terminal has shown the progress.
  if (isatty(STDERR_FILENO) == 0) message("== {}: {}\n", title, duration(seconds));
  return {title, seconds, written};
}

double size_of(const std::filesystem::path& what) {
  if (!std::filesystem::is_directory(what)) return static_cast<double>(std::filesystem::file_size(what));
  double sum = 0;
  for (const auto& entry : std::filesystem::directory_iterator(what)) sum += static_cast<double>(entry.file_size());
  return sum;
}

/// The files of a run except database and model.
constexpr const char* text_files[] = {
    "mesh.msh",    "mesh.json", "precompute.json",     "check.json",    "train.json",  "calibrate.json",
    "reduce.json", "body.txt",  "calibrate_body.json", "validate.json", "stages.json", "organ.html"};

void declare_files(const Options& options) {
  for (const char* name : text_files) declare_output("--output", options.output / name);
  declare_output("--output", options.output / "database.h5", PathKind::database);
  declare_output("--output", options.output / "model", PathKind::model);
}

/// A new run replaces no files. A resumed run replaces those of an earlier run if the database has rays of the scene.
/// @return the coverage of the scene's rays by the database
/// @throws Error (input) before anything is written
Coverage check_existing_files(const Options& options) {
  const auto database = options.output / "database.h5", model = options.output / "model";
  auto database_coverage = Coverage::other;
  DatabaseLock::require_free(database);
  if (DatabaseWriter::refuse_begun(database, options.resume)) {
    const auto loaded = load_scene(options.scene, true, {}, database);
    const auto header = database_header(loaded.scene, loaded.mesh, loaded.sets);
    database_coverage = coverage(read_database_header(database), header);
    if (database_coverage == Coverage::other) DatabaseWriter::check(database, header, true);
    if (!Database::is_complete(database)) database_coverage = Coverage::part;
  }
  if (options.resume) {
    check_place("--output", model, PathKind::model);
    return database_coverage;
  }
  std::vector<std::filesystem::path> written{model};
  for (const char* name : text_files) written.push_back(options.output / name);
  for (const auto& file : written)
    if (std::filesystem::exists(std::filesystem::symlink_status(file)))
      throw input_error("a run would replace a file", "--output " + file.string(),
                        "give another folder, or --resume if an earlier run has left it");
  return database_coverage;
}

/// Prints the size of the body, and how long its steps took in reduce.
void print_body(const std::filesystem::path& figures_of_reduce) {
  std::ifstream in(figures_of_reduce);
  const auto made = json::parse(in, nullptr, false);
  if (!made.is_object() || !made.contains("sizes")) return;
  for (const auto& size : made["sizes"])
    if (size["modes"] == made["modes"] && size["cells"] == made["cells"]) {
      const double step_ms = 1e3 * size["errors"]["step_s"].get<double>();
      print_result("body.txt       {} modes, {} cells; one of Newton's steps takes {:.2g} ms{}\n",
                   made["modes"].get<int>(), made["cells"].get<int>(), step_ms,
                   step_ms > 0.5 ? " of a cycle of 1 ms (phynness reduce --modes makes smaller bodies)" : "");
    }
}

/// Writes the figures of all stages, also of an earlier run, to one file.
void write_figures(const Options& options) {
  if (!options.json_file) return;
  json all;
  for (const char* title :
       {"mesh", "precompute", "check", "train", "calibrate", "reduce", "calibrate_body", "validate"}) {
    std::ifstream file(options.output / fmt::format("{}.json", title));
    if (file) all[title] = json::parse(file);
  }
  write_json(options.json_file, all);
}

/// Largest number of probes of the check of a scene; 0: there is none.
int check_probes(const Scene& scene) { return scene.validation.check_probes.value_or(DiscretizationOptions().probes); }

/// Whether an earlier run of this scene has completed check.json, `with_all` comparisons or those that it had time for.
bool is_checked(const std::filesystem::path& file, const Scene& scene, bool with_all) {
  std::ifstream in(file);
  auto check = std::filesystem::is_regular_file(file) ? json::parse(in, nullptr, false) : json();
  if (!check.is_object() || check["interrupted"] != false || check["physics_hash"] != physics_hash(scene)) return false;
  const auto number = [&](const char* key) { return check[key].is_number() ? check[key].get<double>() : 0; };
  constexpr double rounding = 1.01;
  return number("most_probes") >= check_probes(scene) &&
         (!with_all || number("sufficient_seconds") <= rounding * number("seconds"));
}

/// Compares the finite elements with a finer solution within check_limit_s. A failure is a warning.
/// @return whether check.json is complete
bool check(const Options& options, const Scene& scene, const std::string& self, std::vector<Stage>& stages,
           RunStages& run_stages) {
  const auto file = options.output / "check.json", database = options.output / "database.h5";
  const int probes = check_probes(scene);
  const bool is_limited = !scene.validation.check_probes;  // in time
  if (probes != 0 && options.resume && is_checked(file, scene, !is_limited)) return true;
  if (probes == 0 && !std::filesystem::exists(file)) return false;
  run_stages.invalidate("check");
  std::filesystem::remove(file);
  if (probes == 0) return false;
  // A stage takes longer than its solves on a busy machine, and after --resume it has solved only some rays.
  const double database_s =
      std::max(stages.back().seconds, summarize(Database::open(database)).seconds / options.ranks);
  const double seconds = check_limit_s(database_s, 1);
  try {
    stages.push_back(stage("check", file,
                           {self, "check", options.scene.string(), "--mesh", (options.output / "mesh.msh").string(),
                            "--probes", std::to_string(probes), "--seconds",
                            fmt::format("{:.3g}", is_limited ? seconds : 1e7), "--json", file.string()},
                           1));
  } catch (const Error&) {
    if (stop_requested()) throw;
    message("warning: the finite elements are not compared with a finer solution; the reason is above\n");
  }
  return is_checked(file, scene, false);
}

/// Adds error bounds to the model or the body. A failure is a warning. @return whether there are bounds
bool calibrate(const Options& options, const std::string& self, bool of_body, std::vector<Stage>& stages) {
  const auto model = options.output / "model", body = options.output / "body.txt";
  const auto figures = options.output / (of_body ? "calibrate_body.json" : "calibrate.json"),
             database = options.output / "database.h5";
  std::vector<std::string> arguments{
      self,     "calibrate",     model.string(), database.string(), "--scene", options.scene.string(),
      "--json", figures.string()};
  if (of_body) arguments.insert(arguments.end(), {"--body", body.string()});
  try {
    stages.push_back(stage(of_body ? "calibrate body" : "calibrate", of_body ? body : model / "model.txt", arguments,
                           options.ranks));
    return true;
  } catch (const Error&) {
    if (stop_requested()) throw;
    message("warning: the {} has no error bounds; the reason is above\n", of_body ? "body" : "model");
  }
  return false;
}

void run(const Options& options) {
  declare_files(options);
  const Scene parsed_scene = open_scene(options.scene);
  const auto database_coverage = check_existing_files(options);
  install_stop_handler(false);
  make_folder(options.output);
  const auto self = this_program();
  const auto path_of = [&](const char* name) { return (options.output / name).string(); };
  const auto scene = options.scene.string();
  prepare_environment(options.ranks);
  if (const int cores = static_cast<int>(std::thread::hardware_concurrency()); cores > 0 && options.ranks > cores)
    message("warning: --ranks {} are more processes than this machine has processor cores; --ranks {} is faster\n",
            options.ranks, cores);

  std::vector<Stage> stages;
  stages.push_back(stage("mesh", path_of("mesh.msh"),
                         {self, "mesh", scene, "-o", path_of("mesh.msh"), "--json", path_of("mesh.json")}, 1));
  std::vector<std::string> precompute{self,
                                      "precompute",
                                      scene,
                                      "--mesh",
                                      path_of("mesh.msh"),
                                      "-o",
                                      path_of("database.h5"),
                                      "--json",
                                      path_of("precompute.json")};
  if (options.resume) precompute.push_back("--resume");
  RunStages run_stages(options.output, parsed_scene, database_coverage == Coverage::same);
  stages.push_back(stage("precompute", path_of("database.h5"), precompute, options.ranks));
  run_stages.mark_finished("precompute");
  std::vector<std::string> train{self, "train",          scene,    path_of("database.h5"),
                                 "-o", path_of("model"), "--json", path_of("train.json")};
  if (check(options, parsed_scene, self, stages, run_stages))
    train.insert(train.end(), {"--check", path_of("check.json")});
  run_stages.mark_finished("check");
  std::string kept_stages;
  const auto run_unless_finished = [&](const char* name, const std::function<bool()>& make) {
    if (run_stages.has(name)) {
      kept_stages += fmt::format("{}{}", kept_stages.empty() ? "" : ", ", name);
      return;
    }
    run_stages.invalidate(name);
    if (make()) run_stages.mark_finished(name);
  };
  run_unless_finished("train", [&] {
    stages.push_back(stage("train", path_of("model"), train, 1));
    return true;
  });
  if (!schema::traits(parsed_scene.training.family).proportional)
    run_unless_finished("calibrate", [&] { return calibrate(options, self, false, stages); });
  const bool has_body = parsed_scene.probe.tools > 1;
  std::vector<std::string> validate{self, "validate", scene, path_of("model"), "--json", path_of("validate.json")},
      view{self,
           "view",
           path_of("model"),
           "--database",
           path_of("database.h5"),
           "--errors",
           path_of("validate.json"),
           "-o",
           path_of("organ.html")};
  if (has_body) {
    run_unless_finished("reduce", [&] {
      stages.push_back(stage("reduce", path_of("body.txt"),
                             {self, "reduce", path_of("database.h5"), "--scene", scene, "-o", path_of("body.txt"),
                              "--json", path_of("reduce.json")},
                             options.ranks));
      return true;
    });
    run_unless_finished("calibrate body", [&] { return calibrate(options, self, true, stages); });
    validate.insert(validate.end(), {"--pairs", std::to_string(pairs_in_run), "--body", path_of("body.txt")});
    view.insert(view.end(), {"--body", path_of("body.txt")});
  } else if (std::filesystem::exists(path_of("body.txt"))) {
    run_stages.invalidate("reduce");
  }
  run_unless_finished("validate", [&] {
    stages.push_back(stage("validate", path_of("validate.json"), validate, options.ranks));
    return true;
  });
  run_unless_finished("page", [&] {
    if (embedded_page().empty()) {
      message("note: no page of the model is written\n  remedy: {}\n", missing_pages_remedy());
      return false;
    }
    stages.push_back(stage("page", path_of("organ.html"), view, 1));
    return true;
  });
  if (!kept_stages.empty())
    message("note: kept from an earlier run, because nothing that they depend on has changed: {}\n", kept_stages);
  print_result("\n{:<14} {:>12} {:>10}  written\n", "stage", "time", "size");
  for (const auto& s : stages)
    print_result("{:<14} {:>12} {:>10}  {}\n", s.title, duration(s.seconds), bytes(size_of(s.written)),
                 s.written.string());
  if (has_body) print_body(path_of("reduce.json"));
  write_figures(options);
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "run",
      "Run the whole pipeline: mesh, precompute, check, train, calibrate, reduce, validate, view -> OUT_DIR", run);
  add_scene(command, options.scene, "scene file (formats/scene.md)");
  add_output(command, options.output, PathKind::folder, "folder for all output files");
  add_count(command, "--ranks", options.ranks, 1, 4096, "number of processes for the finite element stages (mpirun)")
      ->capture_default_str();
  command.add_flag("--resume", options.resume,
                   "continue the database in OUT_DIR, also to more points, directions and\nincrements of the scene");
  add_json(command, options.json_file, "write the figures of all stages as JSON");
}

}  // namespace phynness::cli::run_command
