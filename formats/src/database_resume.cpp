#include "database_resume.hpp"

#include <locale>
#include <map>
#include <phynness/formats/error.hpp>
#include <sstream>

namespace phynness {
namespace {

std::map<std::string, std::string> summary_of(const DatabaseHeader& header) {
  const auto scene = stored_scene(header);
  std::istringstream lines(physics_summary(scene));
  std::map<std::string, std::string> values;
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find(" = ");
    values[line.substr(0, equals)] = line.substr(equals + 3);
  }
  return values;
}

/// One line for each different key.
std::string differences(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::string& other) {
  const std::string hashes = "physics " + on_disk.physics_hash + " in the file, " + wanted.physics_hash + " " + other;
  std::map<std::string, std::string> then, now;
  try {
    then = summary_of(on_disk);
    now = summary_of(wanted);
  } catch (const Error&) {
    return hashes;
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
    if (old_value != new_value) text += "\n  " + key + ": " + old_value + " in the file, " + new_value + " " + other;
  }
  return text.empty() ? hashes : text;
}

std::string count_of(const Mesh& mesh) {
  return std::to_string(mesh.n_nodes()) + " nodes, " + std::to_string(mesh.n_cells()) + " cells, ";
}

std::string text(const std::optional<MirrorSymmetry>& mirror) {
  if (!mirror) return "none";
  std::int64_t on_plane = 0;
  for (std::size_t i = 0; i < mirror->image.size(); ++i) on_plane += static_cast<std::size_t>(mirror->image[i]) == i;
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << "normal " << mirror->normal[0] << " " << mirror->normal[1] << " " << mirror->normal[2]
      << ", mirrored pairs of nodes: " << (static_cast<std::int64_t>(mirror->image.size()) - on_plane) / 2
      << (mirror->odd ? ", opposite directions too" : "");
  return out.str();
}

std::string text(const std::vector<Field>& fields) {
  std::string names;
  for (const auto field : fields) {
    if (!names.empty()) names += ", ";
    names += name(field);
  }
  return names.empty() ? "none" : names;
}

}  // namespace

void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file,
                       const std::string& other, const std::string& remedy) {
  const std::string name = "the database " + file.string();
  const auto both = [&](const std::string& then, const std::string& now) {
    return then + " in the file, " + now + " " + other;
  };
  if (on_disk.physics_hash != wanted.physics_hash)
    throw input_error(name + " has another physics", differences(on_disk, wanted, other), remedy);
  if (on_disk.mesh_hash != wanted.mesh_hash)
    throw input_error(
        name + " has another mesh",
        both(count_of(on_disk.mesh) + "hash " + on_disk.mesh_hash, count_of(wanted.mesh) + "hash " + wanted.mesh_hash),
        "use the mesh with which it was begun (a new mesh of the same body is another mesh), or write to another file");
  const auto require_same = [&](const auto& then, const auto& now, const char* what) {
    if (then != now)
      throw input_error(name + " has other " + what,
                        both(std::to_string(then.size()), std::to_string(now.size())) +
                            (then.size() == now.size() ? ", but not the same" : ""),
                        remedy);
  };
  require_same(on_disk.sets.fixed, wanted.sets.fixed, "fixed nodes");
  require_same(on_disk.sets.active, wanted.sets.active, "active nodes");
  require_same(on_disk.sets.output, wanted.sets.output, "output nodes");
  if (on_disk.sets.mirror != wanted.sets.mirror) {
    const auto then = text(on_disk.sets.mirror), now = text(wanted.sets.mirror);
    throw input_error(name + " has another mirror plane", both(then, now) + (then == now ? ", but other pairs" : ""),
                      remedy);
  }
  require_same(on_disk.directions, wanted.directions, "directions");
  require_same(on_disk.magnitudes_m, wanted.magnitudes_m, "increments");
  if (on_disk.tangents != wanted.tangents)
    throw input_error(name + " has another [database] tangents",
                      both(on_disk.tangents ? "true" : "false", wanted.tangents ? "true" : "false"), remedy);
  if (on_disk.float64 != wanted.float64)
    throw input_error(name + " has another [database] displacement_precision",
                      both(on_disk.float64 ? "float64" : "float32", wanted.float64 ? "float64" : "float32"), remedy);
  if (on_disk.fields != wanted.fields)
    throw input_error(name + " has other [database] fields", both(text(on_disk.fields), text(wanted.fields)), remedy);
}

}  // namespace phynness
