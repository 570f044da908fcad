#include "database_study.hpp"

#include <algorithm>
#include <locale>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>
#include <sstream>

#include "database_layout.hpp"
#include "ray_columns.hpp"

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

/// False for a hash of a version that this program does not know: its scene then does not tell what was solved.
bool is_understood(const DatabaseHeader& header) {
  try {
    return physics_hash(stored_scene(header)) == header.physics_hash;
  } catch (const Error&) {
    return false;
  }
}

bool same_points_and_cells(const Mesh& a, const Mesh& b) {
  return a.nodes.rows() == b.nodes.rows() && a.cells.rows() == b.cells.rows() && a.cells.cols() == b.cells.cols() &&
         a.nodes == b.nodes && a.cells == b.cells;
}

const char* const other_physics = "another physics";

/// Whether a line of the summary tells which nodes and directions are chosen, or which rays are mirror images. These
/// are compared themselves.
bool is_selection(const std::string& key) {
  return key.starts_with("nodes.") || key == "probe.directions" || key == "mesh.symmetry";
}

/// One line for each different key.
std::string differing_keys(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::string& other,
                           bool selections) {
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
    if (old_value != new_value && (selections || !is_selection(key)))
      text += "\n  " + key + ": " + old_value + " in the file, " + new_value + " " + other;
  }
  return text.empty() && selections ? hashes : text;
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

std::string text(const std::vector<Field>& fields) { return fields.empty() ? "none" : names(fields, ", "); }

}  // namespace

std::vector<Difference> differences(const DatabaseHeader& on_disk, const DatabaseHeader& wanted,
                                    const std::string& other) {
  std::vector<Difference> all;
  const auto both = [&](const std::string& then, const std::string& now) {
    return then + " in the file, " + now + " " + other;
  };
  const auto compare_lists = [&](const auto& then, const auto& now, const char* what, bool of_rays) {
    if (then != now)
      all.push_back({std::string("other ") + what,
                     both(std::to_string(then.size()), std::to_string(now.size())) +
                         (then.size() == now.size() ? ", but not the same" : ""),
                     of_rays});
  };
  const auto compare = [&](const auto& then, const auto& now, const char* what, const auto& text) {
    if (then != now) all.push_back({what, both(text(then), text(now)), true});
  };
  if (on_disk.is_imported() != wanted.is_imported())
    all.push_back({"other responses",
                   both(on_disk.is_imported() ? "imported" : "solved", wanted.is_imported() ? "imported" : "solved"),
                   true});
  else if (on_disk.physics_hash != wanted.physics_hash)
    all.push_back(
        {"another physics", differing_keys(on_disk, wanted, other, true),
         !is_understood(on_disk) || !is_understood(wanted) || !differing_keys(on_disk, wanted, other, false).empty()});
  if (on_disk.mesh_hash != wanted.mesh_hash || !same_points_and_cells(on_disk.mesh, wanted.mesh))
    all.push_back(
        {"another mesh",
         both(count_of(on_disk.mesh) + "hash " + on_disk.mesh_hash, count_of(wanted.mesh) + "hash " + wanted.mesh_hash),
         true});
  compare_lists(on_disk.sets.fixed, wanted.sets.fixed, "fixed nodes", true);
  compare_lists(on_disk.sets.active, wanted.sets.active, "active nodes", false);
  compare_lists(on_disk.sets.output, wanted.sets.output, "output nodes", false);
  if (on_disk.sets.mirror != wanted.sets.mirror) {
    const auto then = text(on_disk.sets.mirror), now = text(wanted.sets.mirror);
    all.push_back({"another mirror plane", both(then, now) + (then == now ? ", but other pairs" : ""), false});
  }
  compare_lists(on_disk.directions, wanted.directions, "directions", false);
  compare_lists(on_disk.magnitudes_m, wanted.magnitudes_m, "increments", true);
  compare(on_disk.tangents, wanted.tangents, "another [database] tangents",
          [](bool stored) { return std::string(stored ? "true" : "false"); });
  compare(on_disk.float64, wanted.float64, "another [database] displacement_precision",
          [](bool float64) { return std::string(float64 ? "float64" : "float32"); });
  compare(on_disk.fields, wanted.fields, "other [database] fields",
          [](const std::vector<Field>& fields) { return text(fields); });
  return all;
}

void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file,
                       const std::string& other, const std::string& remedy) {
  const auto all = differences(on_disk, wanted, other);
  if (all.empty()) return;
  const auto& first = all.front();
  const bool shares = std::none_of(all.begin(), all.end(), [](const auto& each) { return each.of_rays; });
  const bool physics = on_disk.physics_hash != wanted.physics_hash;
  const bool same_scene = physics && on_disk.scene_text == wanted.scene_text;
  throw input_error(
      "the database " + file.string() +
          (same_scene ? " was solved by another version, with other equations" : " has " + first.what),
      first.values,
      same_scene ? "solve the scene anew into another file; phynness train reads this one as it is"
      : !physics && on_disk.mesh_hash != wanted.mesh_hash
          ? "use the mesh with which it was begun (a new mesh of the same body is another mesh), or write to another "
            "file"
          : remedy + (shares ? "; phynness precompute --from takes the rays that both have" : ""));
}

Coverage coverage(const DatabaseHeader& on_disk, const DatabaseHeader& wanted) {
  const auto all = differences(on_disk, wanted);
  if (all.empty()) return Coverage::same;
  if (std::any_of(all.begin(), all.end(), [](const auto& each) { return each.of_rays; }) ||
      on_disk.directions != wanted.directions || on_disk.sets.mirror != wanted.sets.mirror ||
      stored_scene(on_disk).probe.directions != stored_scene(wanted).probe.directions)
    return Coverage::other;
  const auto has = [](const NodeSets& more, const NodeSets& less) {
    return std::includes(more.active.begin(), more.active.end(), less.active.begin(), less.active.end()) &&
           std::includes(more.output.begin(), more.output.end(), less.output.begin(), less.output.end());
  };
  if (has(on_disk.sets, wanted.sets)) return Coverage::whole;
  return on_disk.sets.output == wanted.sets.output && has(wanted.sets, on_disk.sets) ? Coverage::part : Coverage::other;
}

Arrangement arranged(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file) {
  const auto positions = [](const auto& then, const auto& now) {
    std::vector<std::int32_t> found;
    for (const auto& one : now) {
      const auto at = std::find(then.begin(), then.end(), one);
      found.push_back(at == then.end() ? -1 : static_cast<std::int32_t>(at - then.begin()));
    }
    return found;
  };
  Arrangement there{positions(on_disk.sets.active, wanted.sets.active),
                    positions(on_disk.directions, wanted.directions),
                    positions(on_disk.sets.output, wanted.sets.output), on_disk};
  std::string reasons;
  for (const auto& difference : differences(on_disk, wanted)) {
    if (!difference.of_rays) continue;
    const auto keys = difference.what == other_physics ? differing_keys(on_disk, wanted, "now", false) : std::string();
    reasons += keys.empty() ? "\n  " + difference.what + ": " + difference.values : keys;
  }
  if (const auto lacking = std::count(there.output.begin(), there.output.end(), -1); lacking > 0)
    reasons += "\n  output nodes that the database does not hold: " + std::to_string(lacking) + " of " +
               std::to_string(there.output.size());
  if (!reasons.empty())
    throw input_error("no ray of the database " + file.string() + " is one of the scene", reasons,
                      "solve the scene into a database of its own, without this one");
  return there;
}

std::vector<char> Database::rays_for(const std::filesystem::path& file, const DatabaseHeader& wanted) {
  const auto statuses = open(file, wanted).statuses();
  const auto on_disk = read_database_header(file);
  if (database_layout::read_minor(hdf5::File::open(file)) == 0)
    throw input_error("the rays of the database " + file.string() + " have no ends",
                      "a version that does not look for folds has written it", "solve the scene anew");
  const MirroredRays images(on_disk);
  const auto there = arranged(on_disk, wanted, file);
  const auto n = static_cast<std::ptrdiff_t>(wanted.magnitudes_m.size());
  std::vector<char> flags;
  for (auto ray = statuses.begin(); ray != statuses.end(); ray += n) {
    const auto active = there.active[flags.size() / wanted.directions.size()];
    const auto direction = there.direction[flags.size() % wanted.directions.size()];
    // A library that failed may not fail again, and mirror images are solves only up to rounding.
    flags.push_back(active >= 0 && direction >= 0 && *ray != Status::not_requested &&
                    std::find(ray, ray + n, Status::library_error) == ray + n && images.is_solved(active, direction));
  }
  return flags;
}

}  // namespace phynness
