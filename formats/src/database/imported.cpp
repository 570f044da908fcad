// Responses of other programs, read from a file, checked, and written as a database.
#include <phynness/formats/imported.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/formats/version.hpp>

#include "database_log.hpp"
#include "hdf5_file.hpp"

namespace phynness {
namespace {

namespace fs = std::filesystem;

const char* const layout_remedy = "write the file as formats/imported.md describes it";
/// Of a body that is touched, in m: beyond it numbers are in mm.
constexpr double largest_body_m = 10;
/// Energy over force . displacement is 1/2 for linear responses and above 1/20 for all stiffening up to |f| ~ |d|^19.
constexpr double least_energy = 0.05, most_energy = 1;
/// A touched point and its tool may differ by this fraction of the displacement; the mean under a round tool by more,
/// because its weights differ from program to program.
constexpr double most_misplaced = 0.02, most_misplaced_mean = 0.25;

std::string brief(double value) { return number_text(value, std::chars_format::general, 4); }

/// The file as it is read, and the numbers of all rays but the displacements of output nodes.
struct Given {
  explicit Given(const fs::path& path) : file(hdf5::File::open(path)) {}

  hdf5::File file;
  DatabaseHeader header;
  double tool_radius_m = 0;
  std::vector<double> forces_N, energies_J;  ///< [active][direction][increment] flattened, x 3 and x 1

  std::size_t increments() const { return header.magnitudes_m.size(); }
  std::size_t rays() const { return header.sets.active.size() * header.directions.size(); }
  const double* force(std::size_t ray, std::size_t i) const { return &forces_N[3 * (ray * increments() + i)]; }
  Eigen::Vector3d direction(std::size_t ray) const {
    return to_eigen(header.directions[ray % header.directions.size()]);
  }
  /// A ray whose forces are all NaN was not solved.
  bool is_known(std::size_t ray) const {
    return std::any_of(force(ray, 0), force(ray, 0) + 3 * increments(), [](double f) { return !std::isnan(f); });
  }
  std::string name(std::size_t ray) const {
    return "node " + std::to_string(header.sets.active[ray / header.directions.size()]) + ", direction " +
           std::to_string(ray % header.directions.size());
  }

  template <class T>
  std::vector<T> read(const char* dataset, hdf5::Shape shape, const char* unit) const {
    if (file.has_attribute(dataset, "unit") && file.read_text_attribute(dataset, "unit") != unit)
      throw input_error(std::string(dataset) + " has another unit", file.read_text_attribute(dataset, "unit"),
                        std::string("convert the numbers to ") + unit);
    return file.read<T>(dataset, shape);
  }
  /// Rows of `columns` entries, or single entries if `columns` is 0; the file determines their number.
  template <class T>
  std::vector<T> rows(const char* dataset, hsize_t columns, const char* unit) const {
    constexpr hsize_t most = 10'000'000;
    const auto& shape = file.shape(dataset);
    const hsize_t n = shape.empty() ? 0 : shape[0];
    if (n > most) throw input_error(std::string(dataset) + " has too many rows", std::to_string(n), layout_remedy);
    return read<T>(dataset, columns > 0 ? hdf5::Shape{n, columns} : hdf5::Shape{n}, unit);
  }
  /// Numbers of points, `columns` in a row.
  std::vector<std::int32_t> points(const char* dataset, hsize_t columns) const {
    std::vector<std::int32_t> all;
    for (const auto n : rows<std::int64_t>(dataset, columns, "1")) {
      if (n < 0 || n >= header.mesh.nodes.rows())
        throw input_error(std::string(dataset) + " must hold numbers of points", std::to_string(n),
                          "count points from 0, in the order of /points");
      all.push_back(static_cast<std::int32_t>(n));
    }
    return all;
  }
};

void read_body(Given& given) {
  Mesh& mesh = given.header.mesh;
  const auto points = given.rows<double>("/points", 3, "m");
  mesh.nodes = Eigen::Map<const Points>(points.data(), std::ssize(points) / 3, 3);
  const double diagonal =
      mesh.nodes.rows() > 0 ? (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm() : 0;
  if (!mesh.nodes.allFinite() || !(diagonal > 0 && diagonal <= largest_body_m))
    throw input_error("the body has an implausible size", "its diagonal is " + brief(diagonal) + " m",
                      "give all coordinates and displacements in metres: multiply millimetres by 0.001");
  const bool shell = given.file.exists("/triangles");
  if (shell == given.file.exists("/tetrahedra"))
    throw input_error("a body has either /tetrahedra or /triangles",
                      shell ? "the file has both" : "the file has neither", layout_remedy);
  const int corners = shell ? 3 : 4;
  const auto cells = given.points(shell ? "/triangles" : "/tetrahedra", static_cast<hsize_t>(corners));
  mesh.cells = Eigen::Map<const Cells>(cells.data(), std::ssize(cells) / corners, corners);
  for (Eigen::Index c = 0; !shell && c < mesh.cells.rows(); ++c) {  // of either orientation
    const auto edge = [&](int k) -> Eigen::RowVector3d {
      return mesh.nodes.row(mesh.cells(c, k)) - mesh.nodes.row(mesh.cells(c, 0));
    };
    if (edge(1).cross(edge(2)).dot(edge(3)) < 0) std::swap(mesh.cells(c, 2), mesh.cells(c, 3));
  }
  mesh.surface = shell ? Triangles(mesh.cells) : boundary_triangles(mesh.cells);
}

/// A scene without body and material: title and probe.
std::string scene_text(const std::string& title, double tool_radius_m, double depth_m) {
  std::string quoted;
  for (const char c : title) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  const auto number = [](double x) { return number_text(x, std::chars_format::scientific); };
  return "# Imported responses: body and material are those of their source.\ntitle = \"" + quoted + "\"\n[probe]\n" +
         (tool_radius_m > 0 ? "kind = \"patch\"\ntool_radius_m = " + number(tool_radius_m) : "kind = \"node\"") +
         "\nmax_displacement_m = " + number(depth_m) + "\n";
}

/// @throws Error (input) unless there are probes, with ascending nodes and magnitudes
void check_probes(const DatabaseHeader& header) {
  const auto refuse = [](const std::string& what, const std::string& value) {
    throw input_error(what, value, layout_remedy);
  };
  for (const auto& [name, nodes] :
       {std::pair{"/touched", &header.sets.active}, {"/fixed", &header.sets.fixed}, {"/output", &header.sets.output}})
    if (!std::ranges::is_sorted(*nodes, std::less_equal())) refuse(std::string(name) + " must ascend", "");
  if (header.sets.active.empty()) refuse("/touched has no point", "");
  for (const Vec3& e : header.directions)
    if (!(std::abs(to_eigen(e).norm() - 1) < 1e-9)) refuse("/directions must be vectors of a length", "");
  const auto& magnitudes = header.magnitudes_m;
  if (header.directions.empty() || magnitudes.empty() || !(magnitudes[0] > 0) || !std::isfinite(magnitudes.back()) ||
      !std::ranges::is_sorted(magnitudes, std::less_equal()))
    refuse("/directions and /magnitudes must have entries, and magnitudes be positive and ascend", "");
}

void read_probes(Given& given, const std::string& source, const ToolsOf& tools_of) {
  auto& header = given.header;
  header.imported = true;
  header.sets.active = given.points("/touched", 0);
  for (const auto& [name, nodes] : {std::pair{"/fixed", &header.sets.fixed}, {"/output", &header.sets.output}})
    if (given.file.exists(name)) *nodes = given.points(name, 0);
  const auto directions = given.rows<double>("/directions", 3, "1");
  for (std::size_t i = 0; i < directions.size(); i += 3) {
    const auto unit = Eigen::Vector3d::Map(&directions[i]).normalized();
    for (const Vec3& other : header.directions)
      if ((to_eigen(other) - unit).norm() < 1e-6)
        throw input_error("/directions has a direction twice", "row " + std::to_string(i / 3),
                          "give it once, with the mean of both responses");
    header.directions.push_back({unit[0], unit[1], unit[2]});
  }
  header.magnitudes_m = given.rows<double>("/magnitudes", 0, "m");
  if (given.file.exists("/tool_radius")) given.tool_radius_m = given.read<double>("/tool_radius", {1}, "m")[0];
  const auto title = given.file.has_attribute("/", "title") ? given.file.read_text_attribute("/", "title") : source;
  header.scene_text =
      scene_text(title, given.tool_radius_m, header.magnitudes_m.empty() ? 0 : header.magnitudes_m.back());
  header.scene_name = source;
  header.software_version = software_version();
  header.mesh_hash = mesh_hash(header.mesh);
  header.physics_hash = hash_of("imported");  // replaced below
  header.sets.tools = single_nodes(header.sets.active);
  check_probes(header);
  if (given.tool_radius_m > 0)
    header.sets.tools = tools_of(header.mesh, header.sets.fixed, header.sets.active, given.tool_radius_m);
  const hsize_t a = header.sets.active.size(), d = header.directions.size(), i = header.magnitudes_m.size();
  given.forces_N = given.read<double>("/forces", {a, d, i, 3}, "N");
  given.energies_J = given.file.exists("/energies") ? given.read<double>("/energies", {a, d, i}, "J")
                                                    : std::vector<double>(a * d * i, 0);
  if (!header.sets.output.empty())
    given.file.check_shape("/output_displacements", {a, d, i, header.sets.output.size(), 3});
  Fnv1a64 hash;
  hash.add("imported" + header.mesh_hash + header.scene_text);
  for (const std::vector<double>* numbers : {&directions, &std::as_const(header.magnitudes_m),
                                             &std::as_const(given.forces_N), &std::as_const(given.energies_J)})
    hash.add(numbers->data(), numbers->size() * sizeof(double));
  hash.add(header.sets.active.data(), header.sets.active.size() * sizeof(std::int32_t));
  header.physics_hash = hash.hex();
}

/// Signs and units. @throws Error (input) if the forces are reactions, or the energies are not theirs
void check_forces(const Given& given, ImportReport& report) {
  double work = 0;
  std::vector<double> ratios;
  for (std::size_t ray = 0; ray < given.rays(); ++ray) {
    ++(given.is_known(ray) ? report.rays : report.missing_rays);
    const double before = work;
    for (std::size_t i = 0; given.is_known(ray) && i < given.increments(); ++i) {
      const auto force = Eigen::Vector3d::Map(given.force(ray, i));
      const double energy = given.energies_J[ray * given.increments() + i];
      const double along = force.dot(given.header.magnitudes_m[i] * given.direction(ray));
      if (!force.allFinite() || !std::isfinite(energy))
        throw input_error("a force or an energy is not finite", given.name(ray) + ", increment " + std::to_string(i),
                          "correct it, or make all forces of this ray NaN, which leaves it out");
      report.largest_force_N = std::max(report.largest_force_N, force.norm());
      work += along;
      if (energy != 0 && along != 0) ratios.push_back(energy / along);
    }
    if (work < before) report.against.push_back(given.name(ray));
  }
  if (report.rays == 0 || report.largest_force_N == 0)
    throw input_error("there are no forces", std::to_string(report.rays) + " rays", layout_remedy);
  if (work < 0)
    throw input_error("the forces point against the displacements", brief(work) + " N m in the sum",
                      "give the forces that hold the displacements, which are the negative of reactions");
  if (ratios.empty()) return;
  const auto middle = ratios.begin() + std::ssize(ratios) / 2;
  std::nth_element(ratios.begin(), middle, ratios.end());
  report.energy_over_work = *middle;
  if (!(*middle >= least_energy && *middle <= most_energy))
    throw input_error("the energies are not those of the forces",
                      "the median of energy / (force . displacement) is " + brief(*middle) + ", of a spring it is 0.5",
                      "check signs and units (J, N, m); an energy is 0 at rest, and that of the whole body");
}

/// @throws Error (input) unless the displacements of the output nodes are finite and what the tool moves follows it
void check_output(const Given& given, const Ray& ray, std::size_t number) {
  const auto& output = given.header.sets.output;
  const TouchedNodes& tool = given.header.sets.tools[static_cast<std::size_t>(ray.active)];
  const bool is_known = std::ranges::includes(output, tool.nodes);
  for (std::size_t i = 0; i < given.increments(); ++i) {
    const double depth_m = given.header.magnitudes_m[i];
    const auto where = given.name(number) + ", increment " + std::to_string(i);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t o = 0; o < output.size(); ++o) {
      const auto u = Eigen::Vector3d::Map(&ray.displacement[3 * (i * output.size() + o)]);
      if (!(u.norm() <= 10 * depth_m))
        throw input_error("an output node moves ten times as far as the tool",
                          where + ", output node " + std::to_string(output[o]) + ": " + brief(u.norm()) + " m",
                          "give displacements, not positions, in metres");
      const auto touched = std::ranges::lower_bound(tool.nodes, output[o]);
      if (touched != tool.nodes.end() && *touched == output[o])
        mean += tool.weights[static_cast<std::size_t>(touched - tool.nodes.begin())] * u;
    }
    const Eigen::Vector3d wanted = depth_m * given.direction(number);
    // Beside fixed nodes weights have a smaller sum than 1 here, and perhaps in the program that solved.
    const double sum = std::accumulate(tool.weights.begin(), tool.weights.end(), 0.0),
                 apart = std::min((mean - wanted).norm(), (mean / sum - wanted).norm());
    if (is_known && apart > (tool.mean ? most_misplaced_mean : most_misplaced) * depth_m)
      throw input_error(
          tool.mean ? "the mean under the round tool does not follow it" : "the touched node does not follow the tool",
          where + (tool.mean ? "" : ", output node " + std::to_string(tool.nodes[0])) + ": it is " + brief(apart) +
              " m beside the tool",
          "check the order of the axes and of the output nodes; of a round tool give its radius");
  }
}

Ray ray_of(const Given& given, std::size_t number, const double* displacements) {
  const auto n_directions = given.header.directions.size(), n = given.increments();
  Ray ray = empty_ray(given.header, static_cast<std::int32_t>(number / n_directions),
                      static_cast<std::int32_t>(number % n_directions));
  if (!given.is_known(number)) return ray;
  std::fill(ray.status.begin(), ray.status.end(), Status::converged);
  std::copy_n(given.force(number, 0), 3 * n, ray.force.begin());
  std::copy_n(&given.energies_J[number * n], n, ray.energy.begin());
  std::copy_n(displacements, ray.displacement.size(), ray.displacement.begin());
  ray.end = {EndReason::full_depth, given.header.magnitudes_m.back()};
  check_output(given, ray, number);
  return ray;
}

void write(const Given& given, const fs::path& database) {
  const auto& header = given.header;
  const auto n_directions = header.directions.size(), of_ray = 3 * given.increments() * header.sets.output.size();
  std::vector<double> displacements(n_directions * of_ray);
  DatabaseWriter writer(database, header, 0);
  for (std::size_t a = 0; a < header.sets.active.size(); ++a) {
    if (of_ray > 0) given.file.read_slab("/output_displacements", a, 1, displacements.data());
    for (std::size_t d = 0; d < n_directions; ++d)
      writer.append(ray_of(given, a * n_directions + d, displacements.data() + d * of_ray));
  }
  writer.close();
  DatabaseWriter::pack(database, header);
}

/// What the reader of databases refuses has the remedies of a database.
[[noreturn]] void refuse_layout(const Error& error, const fs::path& file) {
  const std::string_view said = error.what();
  if (said.find("database") == said.npos) throw input_error(file.string() + ": " + error.what(), "", "");
  throw input_error(error.what(), "", layout_remedy);
}

}  // namespace

ImportReport import_responses(const fs::path& file, const fs::path& database, const ToolsOf& tools_of) {
  try {
    DatabaseWriter::refuse_begun(database, false);
  } catch (const Error& error) {
    throw input_error(error.what(), "", "choose another name, or delete what is there");
  }
  ImportReport report;
  std::optional<Given> given;
  try {
    given.emplace(file);
    read_body(*given);
    read_probes(*given, file.filename().string(), tools_of);
    check_forces(*given, report);
  } catch (const Error& error) {
    refuse_layout(error, file);
  }
  report.largest_displacement_m = given->header.magnitudes_m.back();
  try {
    DatabaseWriter::create(database, given->header, false);
    write(*given, database);
  } catch (...) {
    std::error_code code;
    fs::remove(database, code);
    remove_logs(database);
    try {
      throw;
    } catch (const Error& error) {
      if (error.kind() == Error::Kind::input) throw;
      throw failure(error.what(), "", "free space, raise the limit or choose another folder, then import again");
    }
  }
  return report;
}

}  // namespace phynness
