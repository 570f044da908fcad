#include <algorithm>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/vtk.hpp>

#include "commands.hpp"

namespace phynness::cli::show_command {
namespace {

struct Options {
  std::filesystem::path database, output;
  std::int32_t node = 0;
  int direction = 0;
};

struct ShownResponse {
  VtkGrid grid;
  /// One per converged increment. The time is the prescribed displacement [m]. Fields: `displacement` [m], `force` [N]
  /// (the total force at the touched node, zero elsewhere), `prescribed` (weight of the tool, 0 to 1), and stored
  /// scalar fields by their column() (0 except at output nodes).
  std::vector<VtkState> states;
  std::vector<int> increments;     ///< increment numbers of the states; the first increment is 1
  std::vector<std::string> notes;  ///< the omitted parts and the reasons
};

std::size_t active_index(const DatabaseHeader& header, std::int32_t node) {
  const auto& active = header.sets.active;
  const auto at = std::lower_bound(active.begin(), active.end(), node);
  if (at != active.end() && *at == node) return static_cast<std::size_t>(at - active.begin());
  if (std::ranges::binary_search(header.sets.linear, node))
    throw input_error("of this node the database has the linear response at rest only", fmt::format("--node {}", node),
                      "give an active node; h5py reads /rest/displacement");
  throw input_error("the database has no responses of this node", fmt::format("--node {}", node),
                    fmt::format("give one of the {} active nodes, {} to {}; phynness info DATABASE --json - lists them",
                                active.size(), active.front(), active.back()));
}

/// The rows of `all` with known nodes only, with point numbers instead of node numbers.
template <class Faces>
Cells cells_between_known(const Faces& all, const std::vector<std::int32_t>& point_of) {
  Cells cells(all.rows(), all.cols());
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    bool known = true;
    for (Eigen::Index k = 0; k < all.cols(); ++k) {
      cells(n, k) = point_of[static_cast<std::size_t>(all(i, k))];
      known = known && cells(n, k) >= 0;
    }
    if (known) ++n;
  }
  cells.conservativeResize(n, Eigen::NoChange);
  return cells;
}

Cells known_cells(const Mesh& mesh, const std::vector<std::int32_t>& point_of, std::size_t n_known,
                  std::vector<std::string>& notes) {
  const auto n_nodes = static_cast<std::size_t>(mesh.n_nodes());
  if (n_known == n_nodes) return cells_between_known(mesh.cells, point_of);
  const auto coverage_note = fmt::format("displacements of {} of {} nodes are known", n_known, n_nodes);
  Cells triangles = cells_between_known(mesh.surface, point_of);
  if (triangles.rows() > 0) {
    notes.push_back(
        fmt::format("{}: the file has {} of {} surface triangles and no tetrahedra (with nodes.output = "
                    "\"all\" all displacements are stored)",
                    coverage_note, triangles.rows(), mesh.surface.rows()));
    return triangles;
  }
  notes.push_back(coverage_note + ", but not the three corners of any surface triangle: the file has points only");
  return Eigen::VectorX<std::int32_t>::LinSpaced(static_cast<Eigen::Index>(n_known), 0,
                                                 static_cast<std::int32_t>(n_known) - 1);
}

/// Displacements are known at output nodes (stored), fixed nodes (zero) and nodes held by the tool (prescribed). The
/// cells are all tetrahedra if every node is known, else surface triangles between known nodes, else the known nodes.
/// @param node       mesh node number of an active node
/// @param direction  index of the direction
/// @throws Error (input) if there is no such ray, or if no increment converged
ShownResponse response_to_show(const Database& database, std::int32_t node, int direction) {
  const auto& header = database.header();
  const auto active = active_index(header, node);
  if (direction < 0 || direction >= static_cast<int>(header.directions.size()))
    throw input_error("there is no such direction", fmt::format("--direction {}", direction),
                      fmt::format("give a number from 0 to {}; formats/database.md describes their order",
                                  header.directions.size() - 1));
  const auto rays = database.rays(static_cast<std::int32_t>(active));
  const Ray& ray = rays[static_cast<std::size_t>(direction)];
  if (std::ranges::count(ray.status, Status::converged) == 0)
    throw input_error("no increment of this ray converged",
                      fmt::format("{}: {}", name(ray.status.front()), meaning(ray.status.front())),
                      "choose another --direction; phynness info counts the outcomes");

  const auto& tool = header.sets.tools[active];
  constexpr std::int32_t unknown = -1;
  std::vector<std::int32_t> point_of(static_cast<std::size_t>(header.mesh.n_nodes()), unknown);
  for (const auto* set : {&header.sets.output, &header.sets.fixed, &tool.nodes})
    for (const auto n : *set) point_of[static_cast<std::size_t>(n)] = 0;
  ShownResponse shown;
  auto& grid = shown.grid;
  for (std::int32_t n = 0; n < header.mesh.n_nodes(); ++n) {
    auto& point = point_of[static_cast<std::size_t>(n)];
    if (point == unknown) continue;
    point = static_cast<std::int32_t>(grid.node_numbers.size());
    grid.node_numbers.push_back(n);
  }
  const auto n_points = std::ssize(grid.node_numbers);
  grid.points = header.mesh.nodes(grid.node_numbers, Eigen::all);
  grid.cells = known_cells(header.mesh, point_of, grid.node_numbers.size(), shown.notes);

  if (grid.cells.rows() == header.mesh.cells.rows()) grid.regions = header.mesh.regions;

  Eigen::MatrixXd weight = Eigen::MatrixXd::Zero(n_points, 1);
  for (std::size_t i = 0; i < tool.nodes.size(); ++i)
    weight(point_of[static_cast<std::size_t>(tool.nodes[i])], 0) = tool.weights[i];
  const auto& output = header.sets.output;
  const Points all = prescribed_displacements(header);
  for (std::size_t i = 0; i < header.magnitudes_m.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    if (ray.status[i] != Status::converged) {
      shown.notes.push_back(
          fmt::format("increment {} is left out: {}: {}", number, name(ray.status[i]), meaning(ray.status[i])));
      continue;
    }
    const Eigen::RowVector3d d = all.row(direction * std::ssize(header.magnitudes_m) + static_cast<Eigen::Index>(i));
    const double depth_m = header.magnitudes_m[i];
    Eigen::MatrixXd u = weight * d, force = Eigen::MatrixXd::Zero(n_points, 3);
    for (std::size_t j = 0; j < output.size(); ++j)
      u.row(point_of[static_cast<std::size_t>(output[j])]) =
          Eigen::Map<const Eigen::RowVector3d>(&ray.displacement[3 * (i * output.size() + j)]);
    force.row(point_of[static_cast<std::size_t>(node)]) = Eigen::Map<const Eigen::RowVector3d>(&ray.force[3 * i]);
    shown.states.push_back(
        {depth_m, {{"displacement", std::move(u)}, {"force", std::move(force)}, {"prescribed", weight}}});
    for (std::size_t f = 0; f < header.fields.size(); ++f) {
      Eigen::MatrixXd values = Eigen::MatrixXd::Zero(n_points, 1);
      for (std::size_t j = 0; j < output.size(); ++j)
        values(point_of[static_cast<std::size_t>(output[j])], 0) = ray.fields[f][i * output.size() + j];
      shown.states.back().fields.push_back({column(header.fields[f]), std::move(values)});
    }
    shown.increments.push_back(number);
  }
  if (const auto n_unstored = grid.node_numbers.size() - output.size(); !header.fields.empty() && n_unstored > 0)
    shown.notes.push_back(
        fmt::format("fields are stored at output nodes only; the file has 0 at {} other points", n_unstored));
  return shown;
}

void write_collection(const ShownResponse& shown, const std::filesystem::path& file) {
  std::vector<std::string> names;
  std::vector<double> times;
  for (std::size_t i = 0; i < shown.states.size(); ++i) {
    names.push_back(fmt::format("{}-{:04d}.vtu", file.stem().string(), shown.increments[i]));
    times.push_back(shown.states[i].time);
    declare_output("--output", file.parent_path() / names.back());
  }
  std::vector<std::pair<std::filesystem::path, std::string>> files;
  for (std::size_t i = 0; i < shown.states.size(); ++i)
    files.emplace_back(file.parent_path() / names[i], vtu_text(shown.grid, shown.states[i]));
  // The last to get its name, so that it never refers to a missing file.
  files.emplace_back(file, pvd_text(names, times));
  write_text_files(files);
}

void run(const Options& options) {
  if (options.output.extension() != ".pvd")
    throw input_error("the format of the output is unknown", options.output.string(),
                      "give -o a name that ends in .pvd");
  const auto database = Database::open(options.database);
  const auto shown = response_to_show(database, options.node, options.direction);
  for (const auto& note : shown.notes) message("note: {}\n", note);
  const auto& header = database.header();
  const auto& e = header.directions[static_cast<std::size_t>(options.direction)];
  const auto title =
      fmt::format("node {}, direction {} ({:.3g} {:.3g} {:.3g})", options.node, options.direction, e[0], e[1], e[2]);
  write_collection(shown, options.output);
  const auto& cells = shown.grid.cells;
  print_result(
      "{}: {} points, {} {}, {} increment{} to {:.4g} m -> {}\n", title, shown.grid.points.rows(), cells.rows(),
      cells.cols() == 4   ? "tetrahedra"
      : cells.cols() == 3 ? "triangles"
                          : "vertices",
      shown.states.size(), shown.states.size() == 1 ? "" : "s", shown.states.back().time, options.output.string());
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(app, "show", "Write a stored response for ParaView", run);
  add_database(command, options.database, "finished database.h5");
  command.add_option("--node", options.node, "number of an active node, starting with 0")->required();
  command.add_option("--direction", options.direction, "number of the direction, starting with 0")->required();
  add_output(command, options.output, PathKind::file,
             "file to write, .pvd, with a .vtu file for each converged increment in the same folder; its time is the "
             "prescribed displacement [m]");
}

}  // namespace phynness::cli::show_command
