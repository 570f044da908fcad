#include "database_study.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "database_layout.hpp"
#include "ray_columns.hpp"
#include "scene/scene_table.hpp"

namespace phynness {
namespace {

std::map<std::string, std::string> summary_of(const Scene& scene) {
  std::istringstream lines(physics_summary(scene));
  std::map<std::string, std::string> values;
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find(" = ");
    values[line.substr(0, equals)] = line.substr(equals + 3);
  }
  return values;
}

bool same_points_and_cells(const Mesh& a, const Mesh& b) {
  return a.nodes.rows() == b.nodes.rows() && a.cells.rows() == b.cells.rows() && a.cells.cols() == b.cells.cols() &&
         a.nodes == b.nodes && a.cells == b.cells;
}

const char* const other_physics = "another physics";
/// Rounding of numbers of a scene that were computed from the same ones in another way.
constexpr double rounding = 1e-12;

bool same_number(double a, double b) { return std::abs(a - b) <= rounding * std::max(std::abs(a), std::abs(b)); }

/// Whether the increments of `shallow` are the first of `deep`, or all.
bool begin_with(const std::vector<double>& deep, const std::vector<double>& shallow) {
  return shallow.size() <= deep.size() && std::equal(shallow.begin(), shallow.end(), deep.begin(), same_number);
}

/// Whether all directions of `then` are directions of `now`. A hemisphere lacks those that pull.
bool has_directions(const DatabaseHeader& now, const DatabaseHeader& then) {
  const auto hemisphere = [](const DatabaseHeader& header) {
    return stored_scene(header).probe.directions == Directions::hemisphere;
  };
  return std::ranges::all_of(then.directions,
                             [&](const Vec3& e) { return std::ranges::count(now.directions, e) > 0; }) &&
         (hemisphere(then) || !hemisphere(now));
}

/// Whether a line of the summary tells which nodes, directions and depths are chosen, which are compared themselves.
bool is_selection(const std::string& key) {
  return key.starts_with("nodes.") || key == "probe.directions" || key == "probe.increments" ||
         key == "probe.max_displacement_m";
}

/// One line for each different key, of selections only if they are wanted.
std::string differing_keys(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, bool selections) {
  auto then = summary_of(stored_scene(on_disk)), now = summary_of(stored_scene(wanted));
  auto keys = then;
  keys.insert(now.begin(), now.end());
  std::string text;
  for (const auto& [key, ignored] : keys) {
    for (auto* values : {&then, &now})
      if ((*values)[key].empty()) (*values)[key] = "absent";
    if (then[key] != now[key] && (selections || !is_selection(key)))
      text += "\n  " + key + ": " + then[key] + " in the file, " + now[key] + " now";
  }
  return text;
}

/// @param value  a product, whose last digits are rounding errors
std::string without_rounding(double value) {
  std::ostringstream text;
  text << std::setprecision(14) << value;
  return text.str();
}

/// Keys with which a scene of nearly this depth has the increments of a database.
std::string remedy_of_increments(const std::vector<double>& magnitudes_m, double depth_m) {
  const double step_m = magnitudes_m.front();
  const double n = std::max(static_cast<double>(magnitudes_m.size()), std::round(depth_m / step_m));
  if (n > static_cast<double>(scene_detail::most_increments)) return Difference().remedy;
  return "keep the length of its increments: increments = " + without_rounding(n) +
         " and max_displacement_m = " + without_rounding(n * step_m);
}

/// Nodes that only the database has, as a selection to add if there are few.
std::string remedy_of_active(const NodeList& on_disk, const NodeList& wanted) {
  NodeList lost;
  std::ranges::set_difference(on_disk, wanted, std::back_inserter(lost));
  constexpr std::size_t few = 40;
  if (lost.size() > few) return "select these nodes, too";
  std::string text;
  for (const auto node : lost) text += (text.empty() ? "" : ", ") + std::to_string(node);
  return "select these nodes, too, by { nodes = [" + text + "] }";
}

std::string count_of(const Mesh& mesh) {
  return std::to_string(mesh.n_nodes()) + " nodes, " + std::to_string(mesh.n_cells()) + " cells, ";
}

}  // namespace

std::vector<Difference> differences(const DatabaseHeader& on_disk, const DatabaseHeader& wanted) {
  std::vector<Difference> all;
  const auto both = [&](const std::string& then, const std::string& now) {
    return then + " in the file, " + now + " now";
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
  if (on_disk.imported != wanted.imported)
    all.push_back({"other responses",
                   both(on_disk.imported ? "imported" : "solved", wanted.imported ? "imported" : "solved"), true});
  else if (on_disk.physics_hash != wanted.physics_hash)
    all.push_back(
        {other_physics, differing_keys(on_disk, wanted, true), !differing_keys(on_disk, wanted, false).empty()});
  if (on_disk.mesh_hash != wanted.mesh_hash || !same_points_and_cells(on_disk.mesh, wanted.mesh))
    all.push_back(
        {"another mesh",
         both(count_of(on_disk.mesh) + "hash " + on_disk.mesh_hash, count_of(wanted.mesh) + "hash " + wanted.mesh_hash),
         true, "use the mesh with which it was begun (a new mesh of the same body is another mesh)"});
  compare_lists(on_disk.sets.fixed, wanted.sets.fixed, "fixed nodes", true);
  if (const auto& then = on_disk.sets.active, &now = wanted.sets.active; then != now) {
    compare_lists(then, now, "active nodes", false);
    all.back().remedy = remedy_of_active(then, now);
  }
  compare_lists(on_disk.sets.output, wanted.sets.output, "output nodes", false);
  compare_lists(on_disk.sets.linear, wanted.sets.linear, "points with a response at rest", false);
  if (const bool more = has_directions(wanted, on_disk); !more || on_disk.directions != wanted.directions)
    all.push_back({"other directions",
                   both(std::to_string(on_disk.directions.size()), std::to_string(wanted.directions.size())), !more});
  if (const auto& then = on_disk.magnitudes_m, &now = wanted.magnitudes_m; then != now)
    all.push_back({"other increments (probe.increments, probe.max_displacement_m)",
                   both(std::to_string(then.size()) + " to " + without_rounding(then.back()) + " m",
                        std::to_string(now.size()) + " to " + without_rounding(now.back()) + " m"),
                   !begin_with(now, then), remedy_of_increments(then, now.back())});
  compare(on_disk.tangents, wanted.tangents, "another [database] tangents",
          [](bool stored) { return std::string(stored ? "true" : "false"); });
  compare(on_disk.float64, wanted.float64, "another [database] displacement_precision",
          [](bool float64) { return std::string(float64 ? "float64" : "float32"); });
  compare(on_disk.field_bits, wanted.field_bits, "another [database] field_tolerance",
          [](int bits) { return bits > 0 ? std::to_string(bits) + " bits" : std::string("every bit"); });
  compare(on_disk.fields, wanted.fields, "other [database] fields",
          [](const auto& fields) { return fields.empty() ? std::string("none") : names(fields, ", "); });
  return all;
}

void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file) {
  const auto all = differences(on_disk, wanted);
  if (all.empty()) return;
  auto reason = std::ranges::find_if(all, &Difference::of_rays);
  const bool loses_rays = reason == all.end() && coverage(on_disk, wanted) == Coverage::other;
  if (reason == all.end())
    reason = std::ranges::find_if(all, [&](const auto& each) { return !loses_rays || each.what != other_physics; });
  throw input_error(
      "the database " + file.string() + " has " + reason->what + (loses_rays ? ", whose rays would be lost" : ""),
      reason->values, reason->remedy + ", or give another -o");
}

Coverage coverage(const DatabaseHeader& on_disk, const DatabaseHeader& wanted) {
  const auto all = differences(on_disk, wanted);
  if (all.empty()) return Coverage::same;
  const bool grows = std::ranges::none_of(all, &Difference::of_rays) &&
                     std::ranges::includes(wanted.sets.active, on_disk.sets.active) &&
                     on_disk.sets.output == wanted.sets.output;
  return grows ? Coverage::part : Coverage::other;
}

void require_same_rays(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file) {
  std::string reasons;
  for (const auto& difference : differences(on_disk, wanted))
    reasons += "\n  " + difference.what + ": " + difference.values;
  if (reasons.empty()) return;
  throw input_error("the database " + file.string() + " does not have all rays of the scene, or has others", reasons,
                    coverage(on_disk, wanted) == Coverage::part
                        ? "solve what is missing with: phynness precompute SCENE -o " + file.string() +
                              " --resume; or train what the database has, without a scene: phynness train " +
                              file.string() + " -o MODEL"
                        : "solve the scene into a database of its own");
}

}  // namespace phynness
