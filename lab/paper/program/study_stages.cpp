#include <fstream>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/studies/json.hpp>
#include <phynness/studies/measure.hpp>
#include <sstream>

#include "child_process.hpp"
#include "console.hpp"
#include "streams.hpp"
#include "study.hpp"

namespace phynness::cli {
namespace {

constexpr int n_surface_levels = 4;  // the paper's Table 2

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

nlohmann::json json_of(const std::filesystem::path& file) {
  const auto parsed = nlohmann::json::parse(read_text(file), nullptr, false);
  return parsed.is_discarded() ? nlohmann::json() : parsed;
}

std::string hash_of(const std::string& text) {
  Fnv1a64 hash;
  hash.add(text);
  return hash.hex();
}

/// Record of the finished stages and their inputs.
class Journal {
 public:
  explicit Journal(const std::filesystem::path& folder) : _file(folder / "stages.json"), _stages(json_of(_file)) {
    if (!_stages.is_object()) _stages = nlohmann::json::object();
  }
  bool has(const std::string& stage, const std::string& key) const {
    return _stages.contains(stage) && _stages.at(stage) == key;
  }
  void add(const std::string& stage, const std::string& key) {
    _stages[stage] = key;
    write_text_file(_file, _stages.dump(1));
  }

 private:
  std::filesystem::path _file;
  nlohmann::json _stages;
};

/// Writes the scene into the folder of the case. A different scene there belongs to another study and is not
/// overwritten, because its results may have taken an hour.
std::string lay_scene(const StudyRun& run, const PaperCase& of, const std::filesystem::path& folder) {
  const auto text = case_scene(of, read_text(run.scenes / of.scene), run.quick);
  const auto file = folder / "scene.toml";
  if (std::filesystem::exists(file) && read_text(file) != text) {
    const auto there = parse_scene(read_text(file), file.string(), run.scenes);
    if (physics_hash(there) != physics_hash(parse_scene(text, of.scene, run.scenes)))
      throw input_error("the folder holds a study of another scene", folder.string(),
                        "remove the folder, or give the study another folder with -o");
  }
  // A relative name of a mesh file refers to the folder of the scene.
  if (parse_scene(text, of.scene, run.scenes).mesh.shape == Shape::none)
    throw input_error("a scene of the study reads its mesh from a file", of.scene, "use a built-in shape");
  write_text_file(file, text);
  return text;
}

/// Settings of the measurements of a case.
nlohmann::json settings_of(const StudyRun& run, const PaperCase& of) {
  return {{"sizes", run.sizes}, {"two_tools", of.two_tools}};
}
std::string measuring_key(const nlohmann::json& settings, const std::string& scene) {
  return hash_of(settings.dump() + scene + std::to_string(measurements_version));
}

}  // namespace

std::filesystem::path case_folder(const StudyRun& run, const PaperCase& of) { return run.output / ("case-" + of.id); }

void run_case(const StudyRun& run, const PaperCase& of, const std::function<std::string()>& how_far) {
  const auto folder = case_folder(run, of);
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code)
    throw input_error("cannot make the folder of a case", folder.string() + ", " + code.message(),
                      "give -o a folder that can be written");
  const auto text = lay_scene(run, of, folder);
  const Scene scene = read_scene(folder / "scene.toml");
  const auto in = [&](const char* name) { return (folder / name).string(); };
  const std::string phynness = PHYNNESS_COMMAND;
  Journal journal(folder);
  const auto announce = [&](const char* stage) {
    if (stop_requested()) throw failure("the study was interrupted", stage, "run it again: finished stages are kept");
    print_result("\n== {}, {}: {}\n", how_far(), of.title, stage);
  };
  const auto stage = [&](const char* name, const std::string& key, bool there, std::vector<std::string> arguments,
                         int ranks) {
    if (there && journal.has(name, key)) return;
    announce(name);
    run_child(std::string(name) + " of " + of.title, std::move(arguments), ranks, false);
    journal.add(name, key);
  };
  const auto exists = [&](const char* name) { return std::filesystem::exists(folder / name); };
  const std::string physics = physics_hash(scene);

  stage("mesh", physics, exists("mesh.msh") && exists("mesh.json"),
        {phynness, "mesh", in("scene.toml"), "-o", in("mesh.msh"), "--json", in("mesh.json")}, 1);
  // A finished database is never solved again.
  if (!exists("database.h5") || !Database::is_complete(folder / "database.h5")) {
    announce("precompute");
    std::vector<std::string> precompute{phynness,          "precompute", in("scene.toml"),     "-o",
                                        in("database.h5"), "--json",     in("precompute.json")};
    if (exists("database.h5")) precompute.push_back("--resume");
    run_child("precompute of " + of.title, precompute, run.ranks, false);
  }
  if (read_database_header(folder / "database.h5").physics_hash != physics)
    throw input_error("the folder holds the database of another scene", in("database.h5"),
                      "remove the folder, or give the study another folder with -o");
  const std::string trained = hash_of(text);
  const auto probes = std::to_string(2 * run.sizes.nodes * run.sizes.probes_per_node);
  const auto validate = [&](const char* name, const char* model, const char* result) {
    stage(name, trained + probes, exists(result),
          {phynness, "validate", in("scene.toml"), in(model), "--probes", probes, "--json", in(result)}, run.ranks);
  };
  if (!of.linear) {
    stage("train-networks", trained, exists("networks/model.txt"),
          {phynness, "train", in("scene.toml"), in("database.h5"), "-o", in("networks"), "--family", "rbfn", "--json",
           in("train-networks.json")},
          1);
    validate("validate-networks", "networks", "validate-networks.json");
  }
  stage("train-ours", trained, exists("ours/model.txt"),
        {phynness, "train", in("scene.toml"), in("database.h5"), "-o", in("ours"), "--family",
         of.linear ? "linear" : "modal", "--json", in("train-ours.json")},
        1);
  validate("validate-ours", "ours", "validate-ours.json");
  auto settings = settings_of(run, of);
  const auto key = measuring_key(settings, text);
  settings["key"] = key;
  write_text_file(folder / "study.json", settings.dump(1));
  stage("measure", key, exists("measured.json"), {this_program(), "measure", folder.string()}, run.ranks);
}

bool is_finished(const StudyRun& run, const PaperCase& of) {
  const auto folder = case_folder(run, of);
  if (!std::filesystem::exists(run.scenes / of.scene) || !std::filesystem::exists(folder / "measured.json") ||
      !std::filesystem::exists(folder / "database.h5"))
    return false;
  const auto text = case_scene(of, read_text(run.scenes / of.scene), run.quick);
  return Journal(folder).has("measure", measuring_key(settings_of(run, of), text));
}

CaseResult read_case(const StudyRun& run, const PaperCase& of) {
  const auto folder = case_folder(run, of);
  CaseResult result;
  result.of = of;
  const auto database = Database::open(folder / "database.h5");
  const auto& header = database.header();
  const auto summed = summarize(database);
  auto& f = result.facts;
  f.nodes = header.mesh.n_nodes();
  f.free_nodes = static_cast<std::int64_t>(header.sets.active.size());
  f.surface_nodes = static_cast<std::int64_t>(surface_nodes(header.mesh.surface).size());
  f.cells = header.mesh.n_cells();
  f.corners = header.mesh.cells.cols();
  f.rays = summed.rays;
  for (const auto& [status, n] : summed.states) {
    if (status == Status::not_requested || status == Status::after_end) continue;
    f.increments += n;
    if (status != Status::converged) f.failed += n;
  }
  f.solve_cpu_s = summed.seconds;
  const auto number = [](const nlohmann::json& from, const char* name) {
    return from.is_object() && from.contains(name) ? from.at(name).get<double>() : 0.0;
  };
  f.setup_s = number(json_of(folder / "precompute.json"), "setup_seconds");
  const auto networks_training = json_of(folder / "train-networks.json"),
             ours_training = json_of(folder / "train-ours.json");
  f.networks_train_s = number(networks_training, "seconds");
  f.ours_train_s = number(ours_training, "seconds");
  f.database_bytes = static_cast<double>(std::filesystem::file_size(folder / "database.h5"));
  f.model_bytes = number(networks_training, "model_bytes");
  f.ours_bytes = number(ours_training, "model_bytes");
  f.networks = static_cast<int>(number(networks_training, "networks"));
  f.samples = read_scene(folder / "scene.toml").training.samples;
  f.networks_errors = json_of(folder / "validate-networks.json");
  f.ours_errors = json_of(folder / "validate-ours.json");
  try {
    result.measured = json_of(folder / "measured.json").at("measured").get<CaseMeasurements>();
  } catch (const nlohmann::json::exception& error) {
    throw input_error("the measurements of a case cannot be read",
                      (folder / "measured.json").string() + ", " + error.what(),
                      "remove this file and run the study again, which repeats the measurements");
  }
  if (of.linear) return result;
  const LoadedModel networks(folder / "networks"), ours(folder / "ours");
  if (networks.runtime().triangles().empty()) return result;
  result.times = measure_runtime(networks, ours, n_surface_levels);
  for (int level = 0; level < n_surface_levels; ++level) result.surfaces.push_back(surface_at(networks, level));
  return result;
}

}  // namespace phynness::cli
