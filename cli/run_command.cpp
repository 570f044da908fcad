// Runs mesh, precompute, check, train, calibrate, of several tools reduce, validate and view. Each is a separate
// process, so that the parallel stages run under mpirun and training uses threads.
#include <chrono>
#include <fstream>
#include <phynness/pages/pages.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/discretization.hpp>

#include "commands.hpp"
#include "run_stages.hpp"

namespace phynness::cli::run_command {
namespace {

constexpr const char* pairs = "40";  ///< of tools, with which the body is compared

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
  return {title, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), written};
}

double size_of(const std::filesystem::path& what) {
  if (!std::filesystem::is_directory(what)) return static_cast<double>(std::filesystem::file_size(what));
  double sum = 0;
  for (const auto& entry : std::filesystem::directory_iterator(what)) sum += static_cast<double>(entry.file_size());
  return sum;
}

/// What a run writes beside the database and the model.
constexpr const char* texts[] = {
    "mesh.msh",    "mesh.json", "precompute.json",     "check.json",    "train.json",  "calibrate.json",
    "reduce.json", "body.txt",  "calibrate_body.json", "validate.json", "stages.json", "organ.html"};

void declare_files(const Options& options) {
  for (const char* name : texts) declare_output("--output", options.output / name);
  declare_output("--output", options.output / "database.h5", PathKind::database);
  declare_output("--output", options.output / "model", PathKind::model);
}

/// A new run replaces no file at all, a resumed one those of an earlier run, beside a database of its scene, or of some
/// of its nodes or increments. @return what it has of the scene's rays
/// @throws Error (input) before anything is written
Coverage refuse_files_of_others(const Options& options) {
  const auto database = options.output / "database.h5", model = options.output / "model";
  auto covered = Coverage::other;
  if (DatabaseWriter::refuse_begun(database, options.resume)) {
    const auto loaded = load_scene(options.scene, true, {}, database);
    const auto header = database_header(loaded.scene, loaded.mesh, loaded.sets);
    covered = coverage(read_database_header(database), header);
    if (covered == Coverage::other) DatabaseWriter::check(database, header, true);
    if (!Database::is_complete(database)) covered = Coverage::part;
  }
  if (options.resume) {
    check_place("--output", model, PathKind::model);
    return covered;
  }
  std::vector<std::filesystem::path> written{model};
  for (const char* name : texts) written.push_back(options.output / name);
  for (const auto& file : written)
    if (std::filesystem::exists(std::filesystem::symlink_status(file)))
      throw input_error("a run would replace a file", "--output " + file.string(),
                        "give another folder, or --resume if an earlier run has left it");
  return covered;
}

/// The figures of all stages in one file, also of those that an earlier run has made.
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

/// Whether an earlier run of this scene has finished check.json. Training refuses one of another scene.
bool is_checked(const std::filesystem::path& file, const Scene& scene) {
  std::ifstream in(file);
  auto check = json::parse(in, nullptr, false);
  return check.is_object() && check["interrupted"] == false && check["physics_hash"] == physics_hash(scene);
}

/// Compares the finite elements with a finer solution, in at most a fifth of the time of all: a quarter of that of the
/// database. The model can be used without. @return whether check.json is there
bool check(const Options& options, const Scene& scene, const std::string& self, std::vector<Stage>& stages,
           RunStages& finished) {
  const auto file = options.output / "check.json", database = options.output / "database.h5";
  const auto probes = scene.validation.check_probes;
  if (probes != 0 && options.resume && is_checked(file, scene)) return true;
  if (probes == 0 && !std::filesystem::exists(file)) return false;
  finished.redo("check");
  std::filesystem::remove(file);
  if (probes == 0) return false;
  // On a busy machine a stage takes longer than its solves, and after --resume it has solved only a part of them.
  const double spent_s = std::max(stages.back().seconds, summarize(Database::open(database)).seconds / options.ranks);
  const double seconds = check_limit_s(spent_s, 1);
  try {
    stages.push_back(stage("check", file,
                           {self, "check", options.scene.string(), "--mesh", (options.output / "mesh.msh").string(),
                            "--probes", std::to_string(probes.value_or(DiscretizationOptions().probes)), "--seconds",
                            fmt::format("{:.3g}", probes ? 1e7 : seconds), "--json", file.string()},
                           1));
  } catch (const Error&) {
    if (stop_requested()) throw;
    message("warning: the finite elements are not compared with a finer solution; the reason is above\n");
  }
  return is_checked(file, scene);
}

/// Adds error bounds to the model or the body. Without them it can be used as well. @return whether it has them
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
  const Scene read = open_scene(options.scene);
  const auto covered = refuse_files_of_others(options);
  install_stop_handler(false);
  make_folder(options.output);
  const auto self = this_program();
  const auto in = [&](const char* name) { return (options.output / name).string(); };
  const auto scene = options.scene.string();
  prepare_environment(options.ranks);

  std::vector<Stage> stages;
  stages.push_back(
      stage("mesh", in("mesh.msh"), {self, "mesh", scene, "-o", in("mesh.msh"), "--json", in("mesh.json")}, 1));
  std::vector<std::string> precompute{
      self, "precompute", scene, "--mesh", in("mesh.msh"), "-o", in("database.h5"), "--json", in("precompute.json")};
  if (options.resume) precompute.push_back("--resume");
  RunStages finished(options.output, read, covered == Coverage::same);
  stages.push_back(stage("precompute", in("database.h5"), precompute, options.ranks));
  finished.finished("precompute");
  std::vector<std::string> train{self, "train",     scene,    in("database.h5"),
                                 "-o", in("model"), "--json", in("train.json")};
  if (check(options, read, self, stages, finished)) train.insert(train.end(), {"--check", in("check.json")});
  finished.finished("check");
  std::string kept;
  const auto unless_finished = [&](const char* name, const std::function<bool()>& make) {
    if (finished.has(name)) {
      kept += fmt::format("{}{}", kept.empty() ? "" : ", ", name);
      return;
    }
    finished.redo(name);
    if (make()) finished.finished(name);
  };
  unless_finished("train", [&] {
    stages.push_back(stage("train", in("model"), train, 1));
    return true;
  });
  if (!schema::traits(read.training.family).proportional)
    unless_finished("calibrate", [&] { return calibrate(options, self, false, stages); });
  const bool has_body = read.probe.tools > 1;
  std::vector<std::string> validate{self, "validate", scene, in("model"), "--json", in("validate.json")},
      view{self, "view",          in("model"), "--database", in("database.h5"), "--errors", in("validate.json"),
           "-o", in("organ.html")};
  if (has_body) {
    unless_finished("reduce", [&] {
      stages.push_back(stage(
          "reduce", in("body.txt"),
          {self, "reduce", in("database.h5"), "--scene", scene, "-o", in("body.txt"), "--json", in("reduce.json")},
          options.ranks));
      return true;
    });
    unless_finished("calibrate body", [&] { return calibrate(options, self, true, stages); });
    validate.insert(validate.end(), {"--pairs", pairs, "--body", in("body.txt")});
    view.insert(view.end(), {"--body", in("body.txt")});
  } else if (std::filesystem::exists(in("body.txt"))) {
    finished.redo("reduce");
  }
  unless_finished("validate", [&] {
    stages.push_back(stage("validate", in("validate.json"), validate, options.ranks));
    return true;
  });
  unless_finished("page", [&] {
    if (embedded_page().empty()) {
      message("note: no page of the model is written\n  remedy: {}\n", missing_pages_remedy());
      return false;
    }
    stages.push_back(stage("page", in("organ.html"), view, 1));
    return true;
  });
  if (!kept.empty())
    message("note: kept from an earlier run, because nothing that they depend on has changed: {}\n", kept);
  print_result("\n{:<14} {:>12} {:>10}  written\n", "stage", "time", "size");
  for (const auto& s : stages)
    print_result("{:<14} {:>12} {:>10}  {}\n", s.title, duration(s.seconds), bytes(size_of(s.written)),
                 s.written.string());
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
