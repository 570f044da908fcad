#include "database_checks.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <locale>
#include <map>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "database_layout.hpp"
#include "database_log.hpp"
#include "ray_columns.hpp"

namespace phynness {
namespace {

namespace path = database_layout::path;

const char* const remedy = "the file is damaged, or was written by a defective program: compute the database again";

// Much larger than in any scene (formats/scene.md). Within these limits products of counts do not overflow, and a few
// damaged bytes of a file cannot cause an allocation of all memory.
constexpr std::size_t most_directions = 10000, most_increments = 10000, most_rays = 100'000'000;
// Limits of the diagonal of the body's bounding box [m].
constexpr double smallest_diagonal = 1e-9, largest_diagonal = 1e9;
// Tolerances of the squared lengths of directions and of the plane's normal.
constexpr double direction_rounding = 1e-9, normal_rounding = 1e-12;

std::string text(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

class HeaderChecks {
 public:
  HeaderChecks(const DatabaseHeader& header, const std::string& where) : _header(header), _where(where) {}

  void run() {
    require(_header.mesh.n_nodes() > 0 && _header.mesh.n_cells() > 0, "a mesh");
    require(!_header.sets.active.empty(), "an active node");
    require(!_header.sets.output.empty(), "an output node");
    require(!_header.directions.empty(), "a direction");
    require(!_header.magnitudes_m.empty(), "an increment");
    check_hash(_header.mesh_hash, "mesh_hash");
    check_hash(_header.physics_hash, "physics_hash");
    check_mesh();
    check_sets();
    check_probes();
    check_sizes();
    if (_header.shard) parse_shard(_header.shard->str());
  }

 private:
  void require(bool good, const char* what) const {
    if (!good)
      throw input_error(_where + " must have at least " + what, "it has none",
                        "check the selections and the probe of the scene");
  }
  [[noreturn]] void refuse(const std::string& dataset, const std::string& what, const std::string& value) const {
    throw input_error(_where + ": " + dataset + " " + what, value, remedy);
  }
  [[noreturn]] void refuse_entry(const std::string& dataset, const std::string& what, const std::string& entry,
                                 const std::string& value) const {
    refuse(dataset, what, "entry [" + entry + "] is " + value);
  }

  /// The writer computes empty hashes before this check.
  void check_hash(const std::string& hash, const char* name) const {
    const bool good = hash.size() == 16 && hash.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!good) refuse(std::string("attribute ") + name, "is not 16 hexadecimal digits", "'" + hash + "'");
  }

  template <class Matrix>
  void check_corners(const Matrix& corners, const char* dataset) const {
    for (Eigen::Index i = 0; i < corners.rows(); ++i)
      for (Eigen::Index k = 0; k < corners.cols(); ++k)
        if (corners(i, k) < 0 || corners(i, k) >= _header.mesh.n_nodes())
          refuse_entry(dataset, "contains a node that is not in the mesh", std::to_string(i) + ", " + std::to_string(k),
                       std::to_string(corners(i, k)) + " of " + std::to_string(_header.mesh.n_nodes()) + " nodes");
  }

  void check_mesh() const {
    const Mesh& mesh = _header.mesh;
    for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i)
      for (int k = 0; k < 3; ++k)
        if (!std::isfinite(mesh.nodes(i, k)))
          refuse_entry(path::nodes, "contains a coordinate that is not finite",
                       std::to_string(i) + ", " + std::to_string(k), text(mesh.nodes(i, k)));
    const double diagonal = (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm();
    if (!(diagonal >= smallest_diagonal && diagonal <= largest_diagonal))
      refuse(path::nodes, "define a body of impossible size", "a diagonal of " + text(diagonal) + " m");
    if (mesh.cells.cols() != 3 && mesh.cells.cols() != 4)
      refuse(path::cells, "must have 3 or 4 nodes per cell", std::to_string(mesh.cells.cols()));
    check_corners(mesh.cells, path::cells);
    check_corners(mesh.surface, path::surface);
    int number = 0;
    for (const auto& [name, nodes] : mesh.groups) {
      (void)name;
      check_nodes(nodes, (std::string(path::groups) + "/" + std::to_string(number++)).c_str());
    }
  }

  void check_nodes(const std::vector<std::int32_t>& nodes, const char* dataset) const {
    const auto n = _header.mesh.n_nodes();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i] < 0 || nodes[i] >= n)
        refuse_entry(dataset, "contains a node that is not in the mesh", std::to_string(i),
                     std::to_string(nodes[i]) + " of " + std::to_string(n) + " nodes");
      if (i > 0 && nodes[i] <= nodes[i - 1])
        refuse_entry(dataset, "must be ascending node numbers", std::to_string(i),
                     std::to_string(nodes[i]) + " after " + std::to_string(nodes[i - 1]));
    }
  }

  void check_sets() const {
    check_nodes(_header.sets.fixed, path::fixed);
    check_nodes(_header.sets.active, path::active);
    check_nodes(_header.sets.output, path::output);
    if (!_header.sets.mirror) return;
    // Images must be pairs of nodes, or nodes on the plane; the normal must have the length 1.
    const MirrorSymmetry& mirror = *_header.sets.mirror;
    const auto n = _header.mesh.n_nodes();
    if (mirror.image.size() != static_cast<std::size_t>(n))
      refuse(path::mirror_image, "must have one image for each node",
             std::to_string(mirror.image.size()) + " images of " + std::to_string(n) + " nodes");
    for (std::int32_t i = 0; i < n; ++i) {
      const auto image = mirror.image[static_cast<std::size_t>(i)];
      if (image < 0 || image >= n || mirror.image[static_cast<std::size_t>(image)] != i)
        refuse_entry(path::mirror_image, "must pair the nodes of the mesh", std::to_string(i), std::to_string(image));
    }
    const double length = Eigen::Vector3d::Map(mirror.normal.data()).squaredNorm();
    if (!(std::abs(length - 1) < normal_rounding))
      refuse(path::mirror_normal, "must have the length 1", "its square is " + text(length));
  }

  void check_probes() const {
    for (std::size_t d = 0; d < _header.directions.size(); ++d) {
      const double length = Eigen::Vector3d::Map(_header.directions[d].data()).norm();
      if (!(std::abs(length - 1) < direction_rounding))
        refuse(path::directions, "must hold vectors of length 1",
               "that of entry [" + std::to_string(d) + "] is " + text(length));
    }
    double before = 0;
    const double most = largest_displacement(_header.mesh);
    for (std::size_t i = 0; i < _header.magnitudes_m.size(); ++i) {
      const double magnitude = _header.magnitudes_m[i];
      if (!(magnitude > before) || !(magnitude <= most))
        refuse_entry(path::magnitudes,
                     "must be positive, ascending, and at most 100 diagonals of the body, " + text(most) + " m",
                     std::to_string(i), text(magnitude));
      before = magnitude;
    }
  }

  void check_sizes() const {
    if (_header.directions.size() > most_directions)
      refuse(path::directions, "are too many", std::to_string(_header.directions.size()));
    if (_header.magnitudes_m.size() > most_increments)
      refuse(path::magnitudes, "are too many", std::to_string(_header.magnitudes_m.size()));
    if (_header.sets.active.size() > most_rays / _header.directions.size())
      refuse(path::active, "gives too many rays with the directions",
             std::to_string(_header.sets.active.size()) + " x " + std::to_string(_header.directions.size()));
    const auto bytes = database_log::Layout(_header).payload_bytes;
    if (bytes > std::numeric_limits<std::uint32_t>::max())
      refuse(path::output, "gives rays that are too large for a log", std::to_string(bytes) + " bytes");
  }

  const DatabaseHeader& _header;
  const std::string& _where;
};

}  // namespace

void check_header(const DatabaseHeader& header, const std::string& where) { HeaderChecks(header, where).run(); }

double largest_displacement(const Mesh& mesh) {
  constexpr double diagonals = 100;
  return diagonals * (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm();
}

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
  if (on_disk.physics_hash != wanted.physics_hash)
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

}  // namespace phynness
