#include "run_stages.hpp"

#include <fstream>
#include <iterator>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <sstream>
#include <vector>

#include "commands.hpp"

namespace phynness::cli {
namespace {

/// A stage, the file that it leaves, and the keys of the scene that it reads. It depends on all stages before it, too.
/// mesh, precompute and check themselves compare what is there with what the scene wants.
struct StageRow {
  const char* stage;
  const char* file;
  std::vector<std::string> keys;  ///< whole, or a section with its dot
};
const std::vector<StageRow>& stage_rows() {
  static const std::vector<StageRow> rows{
      // physics: all keys of the physics hash, [mesh] among them
      {"precompute", nullptr, {"physics", "probe.target_error", "database."}},
      {"check", nullptr, {"validation.check_probes"}},  // which training writes into the model
      {"train", "train.json", {"title", "training."}},
      {"calibrate", "calibrate.json", {"validation.calibration_rays"}},
      {"validate", "validate.json", {"validation.probes", "validation.seed"}},
      {"page", "organ.html", {}}};
  return rows;
}

/// The values of the keys of a stage.
std::string values_of(const StageRow& row, const Scene& scene) {
  std::string text;
  for (const auto& key : row.keys) {
    if (key == "physics") text += physics_summary(scene);
    if (key == "title") text += "title = " + scene.title + "\n";
    std::istringstream lines(other_settings(scene));
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with(key)) text += line + "\n";
  }
  return text;
}

std::string hash_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return hash_of(std::string(std::istreambuf_iterator<char>(in), {}));
}

}  // namespace

RunStages::RunStages(const std::filesystem::path& folder, const Scene& scene, bool same_rays) : _folder(folder) {
  Fnv1a64 hash;
  hash.add(software_version());
  for (const auto& row : stage_rows()) {
    hash.add(std::string(row.stage) + "\n" + values_of(row, scene));
    _wanted[row.stage] = hash.hex();
  }
  std::ifstream in(folder / "stages.json");
  const auto found = json::parse(in, nullptr, false);
  if (!same_rays || !found.is_object() || !found.contains("stages") || !found.contains("model")) return;
  const auto& stages = found["stages"];
  if (found["model"] != hash_of_file(folder / "model/model.txt") || !stages.is_object()) return;
  const bool bounded = !schema::traits(scene.training.family).proportional;
  for (const auto& row : stage_rows()) {
    if (!bounded && row.stage == std::string_view("calibrate")) continue;
    const std::string before = stages.contains(row.stage) && stages[row.stage].is_string() ? stages[row.stage] : "";
    if (before != _wanted[row.stage] || (row.file && !std::filesystem::exists(folder / row.file))) return;
    _finished[row.stage] = before;
  }
}

bool RunStages::has(const std::string& stage) const { return _finished.contains(stage); }

void RunStages::redo(const std::string& stage) {
  bool follows = false;
  for (const auto& row : stage_rows()) {
    follows = follows || row.stage == stage;
    if (!follows) continue;
    _finished.erase(row.stage);
    if (row.file) std::filesystem::remove(_folder / row.file);
  }
  write();
}

void RunStages::finished(const std::string& stage) {
  _finished[stage] = _wanted.at(stage);
  write();
}

void RunStages::write() const {
  write_text_file(_folder / "stages.json",
                  record("stages", _finished, "model", hash_of_file(_folder / "model/model.txt")).dump(2) + "\n");
}

}  // namespace phynness::cli
