#include "database_resume.hpp"

#include <map>
#include <phynness/formats/error.hpp>
#include <sstream>

namespace phynness {
namespace {

const char* const remedy = "restore what the database was begun with, or write to another file";

std::map<std::string, std::string> summary_of(const DatabaseHeader& header) {
  const auto scene =
      parse_scene(header.scene_text, header.scene_name, header.scene_folder, MeshFile::may_be_absent);
  std::istringstream lines(physics_summary(scene));
  std::map<std::string, std::string> values;
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find(" = ");
    values[line.substr(0, equals)] = line.substr(equals + 3);
  }
  return values;
}

/// One line per key that differs.
std::string differences(const DatabaseHeader& on_disk, const DatabaseHeader& wanted) {
  std::map<std::string, std::string> then, now;
  try {
    then = summary_of(on_disk);
    now = summary_of(wanted);
  } catch (const Error&) {
    return "physics " + on_disk.physics_hash + " in the file, " + wanted.physics_hash + " now";
  }
  auto keys = then;
  keys.insert(now.begin(), now.end());
  const auto value = [](const auto& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? std::string("absent") : found->second;
  };
  std::string text;
  for (const auto& [key, ignored] : keys) {
    const auto old_value = value(then, key), new_value = value(now, key);
    if (old_value != new_value)
      text += "\n  " + key + ": " + old_value + " in the file, " + new_value + " now";
  }
  return text.empty() ? "physics " + on_disk.physics_hash + " in the file, " + wanted.physics_hash + " now"
                      : text;
}

}  // namespace

void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted,
                       const std::filesystem::path& file) {
  const std::string name = "the database " + file.string();
  if (on_disk.physics_hash != wanted.physics_hash)
    throw input_error(name + " was begun with another physics", differences(on_disk, wanted), remedy);
  if (on_disk.mesh_hash != wanted.mesh_hash)
    throw input_error(name + " was begun on another mesh",
                      "hash " + on_disk.mesh_hash + " in the file, " + wanted.mesh_hash + " now",
                      "use the mesh it was begun on (a remesh is another mesh), or write to another file");
  const auto require_same = [&](bool same, const char* what) {
    if (!same) throw input_error(name + " was begun with other " + what, "", remedy);
  };
  require_same(on_disk.sets.fixed == wanted.sets.fixed, "fixed nodes");
  require_same(on_disk.sets.active == wanted.sets.active, "active nodes");
  require_same(on_disk.sets.output == wanted.sets.output, "output nodes");
  require_same(on_disk.sets.mirror == wanted.sets.mirror, "mirror images of its nodes");
  require_same(on_disk.directions == wanted.directions, "directions");
  require_same(on_disk.magnitudes_m == wanted.magnitudes_m, "increments");
  if (on_disk.tangents != wanted.tangents)
    throw input_error(name + " was begun with another [database] tangents",
                      on_disk.tangents ? "true in the file" : "false in the file", remedy);
  if (on_disk.float64 != wanted.float64)
    throw input_error(name + " was begun with another [database] displacement_precision",
                      on_disk.float64 ? "float64 in the file" : "float32 in the file", remedy);
}

}  // namespace phynness
