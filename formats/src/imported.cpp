// Reading and writing of imported responses.
#include <phynness/formats/imported.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/formats/version.hpp>

#include "database_log.hpp"
#include "hdf5_file.hpp"
#include "imported_checks.hpp"

namespace phynness {
namespace {

using imported::NodeStates;
using imported::State;

const char* const layout_remedy = "write the file as formats/imported.md describes it";

class ResponseFile {
 public:
  explicit ResponseFile(const std::filesystem::path& path) : _file(hdf5::File::open(path)) {}

  bool has(const char* name) const { return _file.exists(name); }
  const hdf5::Shape& shape(const char* name) const { return _file.shape(name); }

  /// n x columns numbers; one column may have the shape (n).
  template <class T>
  std::vector<T> rows(const char* name, hsize_t columns, const char* unit, hsize_t& n) const {
    const auto& shape = _file.shape(name);
    n = shape.empty() ? 0 : shape[0];
    const bool is_list = columns == 1 && shape.size() == 1;
    if (!is_list && (shape.size() != 2 || shape[1] != columns))
      throw input_error(std::string(name) + " has the wrong shape", words_of(shape),
                        "give n x " + std::to_string(columns) + " numbers");
    if (n > static_cast<hsize_t>(most_entries))
      throw input_error(std::string(name) + " has too many rows", std::to_string(n),
                        "give at most " + std::to_string(most_entries) + "; of each node at most 600 are fitted");
    check_unit(name, unit);
    return _file.read<T>(name, shape);
  }
  Points points(const char* name, const char* unit) const {
    hsize_t n = 0;
    const auto numbers = rows<double>(name, 3, unit, n);
    return Eigen::Map<const Points>(numbers.data(), static_cast<Eigen::Index>(n), 3);
  }
  std::vector<std::int32_t> numbers(const char* name) const {
    hsize_t n = 0;
    return narrow(name, rows<std::int64_t>(name, 1, nullptr, n));
  }
  Cells cells(const char* name, int corners) const {
    hsize_t n = 0;
    const auto all = narrow(name, rows<std::int64_t>(name, static_cast<hsize_t>(corners), nullptr, n));
    return Eigen::Map<const Cells>(all.data(), static_cast<Eigen::Index>(n), corners);
  }
  void check_unit(const char* name, const char* unit) const {
    if (!unit || !_file.has_attribute(name, "unit")) return;
    const auto found = _file.read_text_attribute(name, "unit");
    if (found != unit)
      throw input_error(std::string(name) + " has another unit", found, std::string("convert the numbers to ") + unit);
  }
  std::string title() const { return _file.has_attribute("/", "title") ? _file.read_text_attribute("/", "title") : ""; }
  const hdf5::File& file() const { return _file; }

  static std::string words_of(const hdf5::Shape& shape) {
    std::string text;
    for (const auto n : shape) text += (text.empty() ? "" : " x ") + std::to_string(n);
    return text.empty() ? "one number" : text;
  }

 private:
  static constexpr std::int64_t most_entries = 10'000'000;

  static std::vector<std::int32_t> narrow(const char* name, const std::vector<std::int64_t>& wide) {
    std::vector<std::int32_t> all;
    for (const auto n : wide) {
      if (n < 0 || n > std::numeric_limits<std::int32_t>::max())
        throw input_error(std::string(name) + " must hold numbers of points", std::to_string(n), "count points from 0");
      all.push_back(static_cast<std::int32_t>(n));
    }
    return all;
  }

  hdf5::File _file;
};

/// Reads the displacements of the output nodes by rows, of which a chunk may hold several.
std::function<void(std::int64_t, double*)> output_reader(const std::shared_ptr<const ResponseFile>& file,
                                                         std::size_t n_output, hsize_t n_rows) {
  const char* const name = "/output_displacements";
  const hdf5::Shape expected{n_rows, n_output, 3};
  if (file->shape(name) != expected)
    throw input_error(std::string(name) + " has the wrong shape", ResponseFile::words_of(file->shape(name)),
                      "give " + ResponseFile::words_of(expected) + " numbers: rows, output nodes, components");
  file->check_unit(name, "m");
  return [file, name](std::int64_t row, double* u) { file->file().read_slab(name, static_cast<hsize_t>(row), 1, u); };
}

GivenResponses read(const std::filesystem::path& path) {
  const auto file = std::make_shared<const ResponseFile>(path);
  GivenResponses given;
  given.title = file->title();
  given.source = path.filename().string();
  // Before anything large is read.
  const auto rows = file->shape("/displacements").empty() ? 0 : file->shape("/displacements")[0];
  if (rows > static_cast<hsize_t>(most_imported_rows))
    throw input_error("there are too many responses",
                      std::to_string(rows) + " rows, of which " + std::to_string(most_imported_rows) + " are possible",
                      "give every n-th row: of each node at most 600 are fitted");
  given.points_m = file->points("/points", "m");
  if (file->has("/tetrahedra") == file->has("/triangles"))
    throw input_error("a body has either /tetrahedra or /triangles",
                      file->has("/triangles") ? "the file has both" : "the file has neither", layout_remedy);
  given.cells = file->has("/triangles") ? file->cells("/triangles", 3) : file->cells("/tetrahedra", 4);
  given.touched = file->numbers("/touched");
  given.displacements_m = file->points("/displacements", "m");
  given.forces_N = file->points("/forces", "N");
  hsize_t n = 0;
  if (file->has("/energies")) given.energies_J = file->rows<double>("/energies", 1, "J", n);
  if (file->has("/energies") && given.energies_J.empty() && rows > 0)
    throw input_error("/energies is empty", "0 rows", "give one for each displacement, or leave /energies out");
  if (file->has("/fixed")) given.fixed = file->numbers("/fixed");
  if (file->has("/tool_radius")) {
    const auto radius = file->rows<double>("/tool_radius", 1, "m", n);
    if (radius.size() != 1) throw input_error("/tool_radius must be one number", std::to_string(n), layout_remedy);
    given.tool_radius_m = radius[0];
  }
  if (file->has("/output") != file->has("/output_displacements"))
    throw input_error("/output and /output_displacements belong together", "only one of them is there", layout_remedy);
  if (!file->has("/output")) return given;
  given.output = file->numbers("/output");
  if (!given.output.empty()) given.output_displacements = output_reader(file, given.output.size(), rows);
  return given;
}

/// The different displacements of all nodes, by nearest direction and length.
class DisplacementTable {
 public:
  DisplacementTable(const std::vector<NodeStates>& nodes, const std::vector<Vec3>& directions)
      : _of_direction(directions.size()) {
    std::map<Key, std::size_t> all;
    for (const auto& node : nodes)
      for (const auto& state : node.states) all.try_emplace(key(state), 0);
    for (auto& [d, direction] : all) {
      const Eigen::Vector3d x = to_eigen(d);
      const auto nearest = std::max_element(directions.begin(), directions.end(), [&](const Vec3& a, const Vec3& b) {
        return x.dot(to_eigen(a)) < x.dot(to_eigen(b));
      });
      _of_direction[static_cast<std::size_t>(nearest - directions.begin())].push_back(d);
    }
    for (std::size_t k = 0; k < _of_direction.size(); ++k) {
      auto& some = _of_direction[k];
      std::stable_sort(some.begin(), some.end(),
                       [](const Key& a, const Key& b) { return to_eigen(a).norm() < to_eigen(b).norm(); });
      for (std::size_t i = 0; i < some.size(); ++i) _place[some[i]] = {k, i};
      _increments = std::max(_increments, some.size());
      _size += some.size();
    }
  }

  struct Place {
    std::size_t direction = 0, increment = 0;
  };
  Place place(const State& state) const { return _place.at(key(state)); }
  std::size_t increments() const { return _increments; }
  std::size_t size() const { return _size; }
  /// What is left of the block of a direction repeats its longest displacement.
  Points points(const std::vector<Vec3>& directions, double largest_m) const {
    Points all(static_cast<Eigen::Index>(directions.size() * _increments), 3);
    for (std::size_t k = 0; k < directions.size(); ++k)
      for (std::size_t i = 0; i < _increments; ++i) {
        const auto& some = _of_direction[k];
        const Eigen::Vector3d d = some.empty() ? Eigen::Vector3d(largest_m * to_eigen(directions[k]))
                                               : to_eigen(some[std::min(i, some.size() - 1)]);
        all.row(static_cast<Eigen::Index>(k * _increments + i)) = d.transpose();
      }
    return all;
  }

 private:
  using Key = std::array<double, 3>;
  static Key key(const State& state) {
    const auto& d = state.displacement_m;
    return {d[0] + 0.0, d[1] + 0.0, d[2] + 0.0};  // zeros of both signs are equal
  }

  std::vector<std::vector<Key>> _of_direction;
  std::map<Key, Place> _place;
  std::size_t _increments = 0, _size = 0;
};

/// TOML text without control characters.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return out + "\"";
}

std::string scene_text(const GivenResponses& given, double largest_m) {
  std::string text = "# Imported responses: body and material are those of their source.\ntitle = " +
                     quoted(given.title.empty() ? given.source : given.title) + "\n[probe]\n";
  const auto number = [](double x) { return number_text(x, std::chars_format::scientific); };
  text += given.tool_radius_m > 0 ? "kind = \"patch\"\ntool_radius_m = " + number(given.tool_radius_m) + "\n"
                                  : "kind = \"node\"\n";
  return text + "max_displacement_m = " + number(largest_m) + "\n";
}

DatabaseHeader header_of(const GivenResponses& given, const std::vector<NodeStates>& nodes,
                         const DisplacementTable& table, double largest_m) {
  DatabaseHeader header;
  header.mesh.nodes = given.points_m;
  header.mesh.cells = given.cells;
  header.mesh.surface = given.cells.cols() == 4 ? boundary_triangles(given.cells) : Triangles(given.cells);
  header.sets.fixed = given.fixed;
  header.sets.output = given.output;
  for (auto* nodes : {&header.sets.fixed, &header.sets.output}) sort_unique(*nodes);
  for (const auto& node : nodes) header.sets.active.push_back(node.node);
  header.directions = exploratory_directions(Directions::twenty_six);
  const auto n = table.increments();
  for (std::size_t i = 1; i < n; ++i)
    header.magnitudes_m.push_back(largest_m * static_cast<double>(i) / static_cast<double>(n));
  header.magnitudes_m.push_back(largest_m);
  header.displacements_m = table.points(header.directions, largest_m);
  header.scene_text = scene_text(given, largest_m);
  header.scene_name = given.source;
  header.software_version = software_version();
  return header;
}

/// Before hours of writing. @throws Error (input)
void check_size(const DatabaseHeader& header, std::size_t displacements) {
  constexpr double most_of_node = 4e9, most_entries = 5e7;  // bytes in memory; increments of all nodes
  const auto increments = static_cast<double>(header.magnitudes_m.size());
  const auto of_node = increments * static_cast<double>(header.directions.size());
  const double bytes = of_node * (24.0 * static_cast<double>(header.sets.output.size()) + 100);
  const double entries = of_node * static_cast<double>(header.sets.active.size());
  const auto sizes = std::to_string(header.sets.active.size()) + " touched nodes, " + std::to_string(displacements) +
                     " different displacements and " + std::to_string(header.sets.output.size()) + " output nodes";
  if (bytes > most_of_node || entries > most_entries || increments > 10'000)
    throw input_error(
        "the responses are too many for one database", sizes,
        "give the nodes the same displacements where that is possible, fewer rows, or fewer output nodes");
}

class RayMaker {
 public:
  RayMaker(const GivenResponses& given, const DatabaseHeader& header, const DisplacementTable& table)
      : _given(given), _header(header), _table(table), _u(3 * given.output.size()) {
    for (const auto node : header.sets.output)
      _order.push_back(
          static_cast<std::size_t>(std::find(given.output.begin(), given.output.end(), node) - given.output.begin()));
  }

  Ray ray(const NodeStates& node, std::int32_t active, std::size_t direction) {
    Ray ray = empty_ray(_header, active, static_cast<std::int32_t>(direction));
    for (const auto& state : node.states) {
      const auto place = _table.place(state);
      if (place.direction != direction) continue;
      ray.status[place.increment] = Status::converged;
      Eigen::Vector3d::Map(&ray.force[3 * place.increment]) = state.force_N;
      ray.energy[place.increment] = state.energy_J;
      ray.end.reason = EndReason::full_depth;
      ray.end.depth_m = std::max(ray.end.depth_m, state.displacement_m.norm());
      add_output(state, &ray.displacement[3 * _order.size() * place.increment]);
    }
    return ray;
  }

 private:
  void add_output(const State& state, double* to) {
    if (_order.empty()) return;
    for (const auto row : state.rows) {
      _given.output_displacements(row, _u.data());
      for (std::size_t o = 0; o < _order.size(); ++o)
        for (std::size_t k = 0; k < 3; ++k)
          to[3 * o + k] += _u[3 * _order[o] + k] / static_cast<double>(state.rows.size());
    }
  }

  const GivenResponses& _given;
  const DatabaseHeader& _header;
  const DisplacementTable& _table;
  std::vector<std::size_t> _order;  ///< positions of the ascending output nodes in the given ones
  std::vector<double> _u;
};

void write(const GivenResponses& given, const std::vector<NodeStates>& nodes, const DatabaseHeader& header,
           const DisplacementTable& table, const std::filesystem::path& file,
           const std::function<void(std::int64_t, std::int64_t)>& progress, const std::function<void()>& poll) {
  const auto n_directions = std::ssize(header.directions), n_rays = std::ssize(nodes) * n_directions;
  DatabaseWriter::create(file, header, false);
  try {
    DatabaseWriter writer(file, header, 0);
    RayMaker maker(given, header, table);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t k = 0; k < header.directions.size(); ++k) {
        poll();
        writer.append(maker.ray(nodes[a], static_cast<std::int32_t>(a), k));
        if (progress) progress(static_cast<std::int64_t>(a) * n_directions + static_cast<std::int64_t>(k) + 1, n_rays);
      }
    writer.close();
    poll();
    DatabaseWriter::pack(file, header);
  } catch (...) {
    std::error_code code;
    std::filesystem::remove(file, code);
    remove_logs(file);
    throw;
  }
}

}  // namespace

GivenResponses read_responses(const std::filesystem::path& file) {
  try {
    return read(file);
  } catch (const Error& error) {
    // What the reader of databases refuses has the remedies of a database.
    const std::string_view said = error.what();
    if (said.find("database") == std::string_view::npos) throw input_error(file.string() + ": " + error.what(), "", "");
    throw input_error(error.what(), "", layout_remedy);
  }
}

ImportReport import_responses(GivenResponses given, const std::filesystem::path& file,
                              const std::function<void(std::int64_t, std::int64_t)>& progress,
                              const std::function<bool()>& stop) {
  const auto poll = [&] {
    if (stop && stop()) throw failure("the import was interrupted", file.string(), "run it again; nothing was written");
  };
  std::error_code code;
  if (std::filesystem::exists(file, code))
    throw input_error("the database exists and is not overwritten", file.string(),
                      "choose another name, or delete the file");
  ImportReport report;
  imported::check_shapes(given, report);
  const auto nodes = imported::checked_states(given, report);
  Fnv1a64 hash;
  hash.add("imported");
  const auto add = [&](const auto& numbers) {
    hash.add(numbers.data(), static_cast<std::size_t>(numbers.size()) * sizeof *numbers.data());
  };
  add(given.touched), add(given.displacements_m), add(given.forces_N), add(given.energies_J), add(given.output);
  imported::check_output(given, [&](const auto& displacements) {
    poll();
    add(displacements);
  });

  const auto directions = exploratory_directions(Directions::twenty_six);
  const DisplacementTable table(nodes, directions);
  report.displacements = static_cast<std::int64_t>(table.size());
  DatabaseHeader header = header_of(given, nodes, table, report.largest_displacement_m);
  header.mesh_hash = mesh_hash(header.mesh);
  hash.add(header.mesh_hash);
  header.physics_hash = hash.hex();
  check_size(header, table.size());
  write(given, nodes, header, table, file, progress, poll);
  return report;
}

}  // namespace phynness
