#include "database_study.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "database_layout.hpp"
#include "ray_columns.hpp"
#include "scene_table.hpp"

namespace phynness {
namespace {

using scene_detail::shortest;

std::map<std::string, std::string> summary_of(const Scene& scene) {
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
const char* const other_search = "another search for folds";
/// Rounding of numbers of a scene that were computed from the same ones in another way.
constexpr double rounding = 1e-12;

bool same_number(double a, double b) { return std::abs(a - b) <= rounding * std::max(std::abs(a), std::abs(b)); }

/// The factor by which all moduli of `now` are larger, if there is one and all other numbers are the same. Forces,
/// energies and stresses are larger by it, and deformations are the same.
std::optional<double> modulus_factor(const Scene& then, const Scene& now) {
  const auto &a = then.material, &b = now.material;
  if (a.law != b.law) return std::nullopt;
  const double factor = b.shear_modulus_Pa / a.shear_modulus_Pa;
  for (std::size_t i = 0; i < a.parameters.size(); ++i)
    if (!same_number((a.law->parameters[i].is_modulus ? factor : 1) * a.parameters[i], b.parameters[i]))
      return std::nullopt;
  return a.parameters == b.parameters ? 1 : factor;
}

/// Whether the increments of `shallow` are the first of `deep`, or all.
bool begin_with(const std::vector<double>& deep, const std::vector<double>& shallow) {
  return shallow.size() <= deep.size() && std::equal(shallow.begin(), shallow.end(), deep.begin(), same_number);
}

/// Whether a line of the summary tells which nodes, directions and depths are chosen. These are compared themselves,
/// and so are moduli if they have a common factor.
bool is_selection(const std::string& key, bool scales) {
  return key.starts_with("nodes.") || key == "probe.directions" || key == "probe.increments" ||
         key == "probe.max_displacement_m" || (scales && (key.starts_with("material.") || key == "probe.max_force_N"));
}

/// One line for each different key.
std::string differing_keys(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::string& other,
                           bool selections) {
  const std::string hashes = "physics " + on_disk.physics_hash + " in the file, " + wanted.physics_hash + " " + other;
  std::map<std::string, std::string> then, now;
  bool scales = false;
  try {
    const auto before = stored_scene(on_disk), after = stored_scene(wanted);
    then = summary_of(before);
    now = summary_of(after);
    scales = modulus_factor(before, after).has_value();
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
    if (old_value != new_value && (selections || !is_selection(key, scales)))
      text += "\n  " + key + ": " + old_value + " in the file, " + new_value + " " + other;
  }
  return text.empty() && selections ? hashes : text;
}

std::string count_of(const Mesh& mesh) {
  return std::to_string(mesh.n_nodes()) + " nodes, " + std::to_string(mesh.n_cells()) + " cells, ";
}

std::string text(int field_bits) { return field_bits > 0 ? std::to_string(field_bits) + " bits" : "every bit"; }
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
  compare_lists(on_disk.directions, wanted.directions, "directions", false);
  if (const auto& then = on_disk.magnitudes_m, &now = wanted.magnitudes_m; then != now)
    all.push_back({"other increments (probe.increments, probe.max_displacement_m)",
                   both(std::to_string(then.size()) + " to " + shortest(then.back()) + " m",
                        std::to_string(now.size()) + " to " + shortest(now.back()) + " m"),
                   !begin_with(then, now) && !begin_with(now, then)});
  compare(on_disk.tangents, wanted.tangents, "another [database] tangents",
          [](bool stored) { return std::string(stored ? "true" : "false"); });
  compare(on_disk.float64, wanted.float64, "another [database] displacement_precision",
          [](bool float64) { return std::string(float64 ? "float64" : "float32"); });
  if (const int then = on_disk.field_bits, now = wanted.field_bits; then != now)
    all.push_back(
        {"another [database] field_tolerance", both(text(then), text(now)), then > 0 && (now == 0 || now > then)});
  compare(on_disk.fields, wanted.fields, "other [database] fields",
          [](const std::vector<Field>& fields) { return text(fields); });
  if (!is_understood(on_disk) || !is_understood(wanted)) return all;
  const auto then = stored_scene(on_disk), now = stored_scene(wanted);
  const auto factor = modulus_factor(then, now);
  if (const auto before = then.probe.max_force_N, after = now.probe.max_force_N;
      factor && !same_number(*factor * before, after))
    all.push_back({"another [probe] max_force_N",
                   both(shortest(before), shortest(after)) +
                       (*factor == 1 ? ""
                                     : ", but a limit of the force must be larger by the factor of the moduli, " +
                                           shortest(*factor)),
                   true});
  if (!now.material.law->linear)  // which has no folds
    compare(on_disk.fold_halvings, wanted.fold_halvings, other_search,
            [](int halvings) { return "to an increment over 2^" + std::to_string(halvings); });
  return all;
}

void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file,
                       const std::string& other, const std::string& remedy) {
  const auto all = differences(on_disk, wanted, other);
  if (all.empty()) return;
  const auto& first = all.front();
  const bool shares = std::none_of(all.begin(), all.end(), [](const auto& each) { return each.of_rays; });
  const bool physics = on_disk.physics_hash != wanted.physics_hash;
  const bool same_scene = (physics && on_disk.scene_text == wanted.scene_text) || first.what == other_search;
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
      on_disk.directions != wanted.directions)
    return Coverage::other;
  const auto then = stored_scene(on_disk), now = stored_scene(wanted);
  if (then.probe.directions != now.probe.directions || modulus_factor(then, now) != 1.0) return Coverage::other;
  const auto has = [](const NodeSets& more, const NodeSets& less) {
    return std::includes(more.active.begin(), more.active.end(), less.active.begin(), less.active.end()) &&
           std::includes(more.output.begin(), more.output.end(), less.output.begin(), less.output.end());
  };
  if (has(on_disk.sets, wanted.sets) && begin_with(on_disk.magnitudes_m, wanted.magnitudes_m)) return Coverage::whole;
  return on_disk.sets.output == wanted.sets.output && has(wanted.sets, on_disk.sets) &&
                 begin_with(wanted.magnitudes_m, on_disk.magnitudes_m)
             ? Coverage::part
             : Coverage::other;
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
                    positions(on_disk.sets.output, wanted.sets.output), 1, on_disk};
  std::string reasons;
  for (const auto& difference : differences(on_disk, wanted)) {
    if (!difference.of_rays) continue;
    const auto keys = difference.what == other_physics ? differing_keys(on_disk, wanted, "now", false) : std::string();
    reasons += keys.empty() ? "\n  " + difference.what + ": " + difference.values : keys;
  }
  if (const auto lacking = std::count(there.output.begin(), there.output.end(), -1); lacking > 0)
    reasons += "\n  output nodes that the database does not hold: " + std::to_string(lacking) + " of " +
               std::to_string(there.output.size());
  if (reasons.empty()) there.modulus_factor = modulus_factor(stored_scene(on_disk), stored_scene(wanted)).value_or(1);
  if (!reasons.empty())
    throw input_error("no ray of the database " + file.string() + " is one of the scene", reasons,
                      std::string("solve the scene into a database of its own, without this one") +
                          (reasons.find("\n  material.") == std::string::npos
                               ? ""
                               : "; of a material only a factor that all moduli have in common is accepted"));
  return there;
}

std::vector<char> Database::rays_for(const std::filesystem::path& file, const DatabaseHeader& wanted) {
  const auto statuses = open(file, wanted).statuses();
  const auto on_disk = read_database_header(file);
  if (database_layout::read_minor(hdf5::File::open(file)) == 0)
    throw input_error("the rays of the database " + file.string() + " have no ends",
                      "a version that does not look for folds has written it", "solve the scene anew");
  const auto there = arranged(on_disk, wanted, file);
  const auto n = static_cast<std::ptrdiff_t>(wanted.magnitudes_m.size());
  std::vector<char> flags;
  for (auto ray = statuses.begin(); ray != statuses.end(); ray += n) {
    const auto active = there.active[flags.size() / wanted.directions.size()];
    const auto direction = there.direction[flags.size() % wanted.directions.size()];
    // A library that failed may not fail again.
    const bool repeats =
        std::none_of(ray, ray + n, [](Status s) { return s == Status::library_error || s == Status::not_solved; });
    flags.push_back(active >= 0 && direction >= 0 && *ray != Status::not_requested && repeats);
  }
  return flags;
}

}  // namespace phynness
