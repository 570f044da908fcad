#include <fmt/format.h>

#include <algorithm>
#include <phynness/formats/input_file.hpp>
#include <phynness/training/families.hpp>
#include <phynness/validation/named_organ.hpp>

#include "commands.hpp"

namespace phynness::cli::train_command {
namespace {

struct Options {
  std::filesystem::path scene, output;
  OptionalPath database, json_file, check_file;
  std::optional<std::string> family;
  std::vector<std::string> settings;
};

void print_levels(const Model& model) {
  for (std::size_t l = 0; l < model.levels.size(); ++l)
    print_result("level {}: leave-one-out errors of the median node: force {:.3f} %, displacement {:.3f} %\n", l,
                 100 * model.levels[l].error_force, 100 * model.levels[l].error_displacement);
}

void print_fields(const Model& model, const TrainingReport& report, const std::vector<Field>& stored) {
  for (std::size_t f = 0; f < model.fields.size(); ++f) {
    const auto& q = report.modal.fields[f];
    print_result("{}: errors by truncation {:.3f} %, by regression {:.3f} %, of the node's largest value\n",
                 model.fields[f].name, 100 * q.truncation, 100 * q.regression);
  }
  if (stored.empty() || !model.fields.empty()) return;
  std::string names;
  for (const auto field : stored) names += (names.empty() ? "" : ", ") + std::string(name(field));
  message(
      "note: the database's fields ({}) are not modelled: {}\n", names,
      model.shared.modes.rows() > 0 ? "a model without modes has forces only" : "only --family modal models fields");
}

/// [training] of the scene with the changes of the options.
TrainingSpec chosen_spec(const Scene& scene, const Options& options) {
  TrainingSpec spec = changed_training(scene, fmt::format("{}", fmt::join(options.settings, "\n")), "--set");
  for (const auto* family : every_family())
    if (options.family == name(family->family)) spec.family = family->family;
  return spec;
}

/// Reads the distance of `check --json`. @throws Error (input) if it belongs to another scene or is invalid
FinerDistance distance_of(const std::filesystem::path& file, const Scene& scene, const DatabaseHeader& header) {
  FinerDistance distance;
  distance.is_measured = true;
  const auto refuse = [&](const std::string& what) {
    return input_error("not what phynness check --json has written for this scene", file.string() + ": " + what,
                       "run phynness check SCENE --json FILE again");
  };
  try {
    const InputFile about{"the file of check --json", "run phynness check SCENE --json FILE", 1 << 30};
    const auto check = json::parse(read_input_file(file, about));
    if (check.at("mesh_hash") != header.mesh_hash || check.at("physics_hash") != header.physics_hash)
      throw refuse("another mesh or physics");
    const auto& distance_json = check.at("distance");
    const auto read_members = [&](const json& object, auto& members, const auto& recurse) -> void {
      members.describe(members, [&]<class Value>(const char* key, Value& value) {
        if constexpr (Described<Value>) return recurse(object.at(key), value, recurse);
        if (&value == static_cast<void*>(&distance.force_ratio) && !object.contains(key)) return;  // an older check
        if constexpr (std::is_same_v<Value, double>)
          if (object.at(key).is_null()) return;  // of no place
        if constexpr (std::is_same_v<Value, std::int32_t>)
          if (!object.at(key).is_number_integer()) throw refuse("a count is no integer");
        if constexpr (std::is_arithmetic_v<Value>)
          if (!(object.at(key) >= 0 && object.at(key) <= 1e6)) throw refuse(std::string(key) + " is out of range");
        if constexpr (!Described<Value>) object.at(key).get_to(value);
      });
    };
    read_members(distance_json, distance, read_members);
    if (distance.nodes < 1) throw refuse("nodes is out of range");
    if (distance.probes > 0 && (distance_json.at("mean").is_null() || distance_json.at("p95").is_null()))
      throw refuse("probes were compared, but mean or p95 is null");
    distance.has_parts = distance.probes > 0;
  } catch (const nlohmann::json::exception& error) {
    throw refuse(problem_of(error));
  }
  if (distance.element != name(scene.solver.element) ||
      std::count(reference_names.begin() + 1, reference_names.end(), distance.reference) == 0)
    throw refuse("another element or reference");
  return distance;
}

struct Trained {
  std::optional<NamedOrgan> loaded;
  TrainingReport report;
  std::vector<Field> stored;  ///< fields of the database
};

Trained trained(const Options& options) {
  if (!options.database && options.scene.extension() == ".toml")
    throw input_error("an argument is missing", "DATABASE", "add DATABASE; phynness train --help describes it");
  // Without a scene the first argument is the database, which contains its scene.
  auto opened = options.database ? std::nullopt : std::optional(Database::open(options.scene));
  const Scene scene = opened ? stored_scene(opened->header()) : open_scene(options.scene);
  const TrainingSpec spec = chosen_spec(scene, options);
  const auto database = opened ? std::move(*opened) : open_database(scene, *options.database);
  const auto& header = database.header();
  const auto finer = options.check_file ? distance_of(*options.check_file, scene, header) : FinerDistance{};
  Trained t;
  // A signal may end the process at any time, because files are written after all long work.
  end_at_signals("training was interrupted\n  remedy: run the same command again; no model was written\n");
  {
    Progress progress("train", "nodes");
    progress.update(0, static_cast<std::int64_t>(header.sets.active.size()));
    Model model =
        train(database, spec, t.report, [&](std::int64_t done, std::int64_t total) { progress.update(done, total); });
    model.title = scene.title;
    model.relaxation = carried_relaxation(scene);  // the database may be older
    model.finer = finer;
    t.loaded.emplace(std::move(model), header.mesh, options.output.string());
  }
  t.stored = header.fields;
  const ModelTexts texts{t.loaded->text(), write_mesh_text(header.mesh)};
  install_stop_handler();  // both files are written, or none
  write_model_texts(options.output, texts);
  return t;
}

void print(const Trained& t, const std::filesystem::path& output) {
  const Model& model = t.loaded->model();
  const TrainingReport& report = t.report;
  const auto& family = operations(model.family);
  print_result("{} nodes in {}: {}\n", report.n_networks, duration(report.seconds), family.describe(model));
  std::string errors;
  for (const auto& figure : family.figures(report))
    errors += fmt::format("{}{} {:.4g} %", errors.empty() ? "" : ", ", figure.title, 100 * figure.value);
  if (!errors.empty()) print_result("{}\n", errors);
  if (report.n_increments_fitted != report.n_increments_used)
    print_result(
        "{} of {} increments are fitted, spread over the depth of each ray, so that the time of the fits does not grow "
        "with the increments\n",
        report.n_increments_fitted, report.n_increments_used);
  print_levels(model);
  print_fields(model, report, t.stored);
  if (report.n_skipped > 0)
    message("warning: {} active nodes have no converged increment and are omitted from the model\n", report.n_skipped);
  print_result("model.txt {}, mesh.txt {} -> {}\n", bytes(t.loaded->text().size()), bytes(t.loaded->mesh_text_bytes()),
               output.string());
  print_missing_bounds(t.loaded->model());
}

json to_json(const Trained& t) {
  const Model& model = t.loaded->model();
  const TrainingReport& report = t.report;
  const auto sizes = sizes_of(model);  // below the specified ones if a node has few responses
  json out =
      record("family", name(model.family), "networks", report.n_networks, "skipped", report.n_skipped, "increments",
             report.n_increments_used, "increments_fitted", report.n_increments_fitted, "deformation_neurons",
             sizes.deformation_neurons, "force_neurons", sizes.force_neurons, "deformation_spread",
             report.deformation_spread, "force_spread", report.force_spread, "mean_deformation_mse",
             report.mean_deformation_mse, "mean_force_mse", report.mean_force_mse, "seconds", report.seconds,
             "model_bytes", t.loaded->text().size(), "mesh_bytes", t.loaded->mesh_text_bytes());
  for (const auto& figure : operations(model.family).figures(report))
    out[name(model.family)][figure.key] = figure.value;
  for (const auto& level : model.levels)
    out["levels"].push_back(record("error_force", level.error_force, "error_displacement", level.error_displacement));
  for (std::size_t f = 0; f < model.fields.size(); ++f)
    out[name(model.family)]["fields"][model.fields[f].name] = record(
        "truncation_error", report.modal.fields[f].truncation, "regression_error", report.modal.fields[f].regression);
  return out;
}

void run(const Options& options) {
  const Trained result = trained(options);
  print(result, options.output);
  write_json(options.json_file, to_json(result));
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "train", "Train a model on a database -> MODEL_DIR (model.txt, mesh.txt)", run);
  add_scene(command, options.scene,
            "scene from which the database was made, or one with some of its active or output nodes; or the database "
            "alone, which holds its scene");
  add_path(command, "DATABASE", options.database, PathKind::input, "database.h5 of phynness precompute or import");
  add_output(command, options.output, PathKind::model, "model directory to write (formats/model.md)");
  std::string family_descriptions;
  std::vector<std::string> words;
  for (const auto* family : every_family()) {
    words.emplace_back(name(family->family));
    family_descriptions +=
        fmt::format("{}{}: {}", family_descriptions.empty() ? "" : "; ", words.back(), family->about);
  }
  command.add_option("--family", options.family, family_descriptions)->check(CLI::IsMember(words));
  command
      .add_option("--set", options.settings,
                  "KEY=VALUE that replaces a key of [training] of the scene, such as modes=8; may be repeated")
      ->allow_extra_args(false);
  add_path(command, "--check", options.check_file, PathKind::input,
           "file of check --json: the model then holds the distance of its finite elements from a finer solution");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::train_command
