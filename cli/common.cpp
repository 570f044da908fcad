#include <algorithm>
#include <cmath>
#include <phynness/formats/text_file.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/patch_warnings.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/validation/locking.hpp>

#include "commands.hpp"

namespace phynness::cli {

std::string problem_of(const json::exception& error) {
  const std::string text = error.what();  // "[json.exception.type_error.302] type must be ..."
  return text.substr(text.starts_with('[') ? text.find("] ") + 2 : 0);
}

namespace {

/// @throws Error (input) unless `text` is three finite numbers, separated by commas, of a length of at most
/// largest_displacement_m
Vec3 parse_vector(const std::string& text, const std::string& what, const std::string& remedy) {
  const auto fields = fields_of(text);
  Vec3 v{};
  bool is_valid = fields.size() == 3;
  for (std::size_t k = 0; k < 3 && is_valid; ++k) is_valid = parse_number(fields[k], v[k]) && std::isfinite(v[k]);
  if (!is_valid)
    throw input_error("a " + what + " must be three finite numbers separated by commas", "'" + text + "'", remedy);
  if (std::hypot(v[0], v[1], v[2]) > largest_displacement_m)
    throw input_error(fmt::format("a {} is longer than {:g} m", what, largest_displacement_m), "'" + text + "'",
                      "give the " + what + " in metres");
  return v;
}

/// Warns of an unusual depth or tool for the body. @throws Error (input) if it is impossible
void check_sizes(const Scene& scene, const QualityReport& q, bool quiet) {
  const double depth = scene.probe.max_displacement_m;
  const Vec3 extent{q.max_m[0] - q.min_m[0], q.max_m[1] - q.min_m[1], q.max_m[2] - q.min_m[2]};
  const double smallest = smallest_displacement(std::hypot(extent[0], extent[1], extent[2]));
  if (depth / scene.probe.increments < smallest)
    throw input_error(scene.probe.where.str() + ": the first increment is too small for double precision",
                      fmt::format("max_displacement_m = {:g} in {} increments, the smallest is {:.3g} m in this body",
                                  depth, scene.probe.increments, smallest),
                      "displacements are in metres; some per cent of the body's size are usual");
  const auto [thinnest, longest] = std::minmax_element(extent.begin(), extent.end());
  if (depth > *longest)
    throw input_error(scene.probe.where.str() + ": the maximum displacement is longer than the body",
                      fmt::format("max_displacement_m = {:g}, the body is {:.3g} m long", depth, *longest),
                      "give displacements in metres, and check mesh.scale_to_m");
  if (depth > *thinnest && !quiet)
    message("warning: the maximum displacement, {:g} m, exceeds the smallest extent of the body, {:.3g} m\n", depth,
            *thinnest);
  const double radius = scene.probe.tool_radius_m;
  if (radius > *longest)
    throw input_error(scene.probe.where.str() + ": the tool is larger than the body",
                      fmt::format("tool_radius_m = {:g}, the body is {:.3g} m long", radius, *longest),
                      "give radii in metres, and check mesh.scale_to_m");
  if (2 * radius > *longest && !quiet)
    message("warning: the tool, tool_radius_m = {:g}, is wider than the body is long, {:.3g} m\n", radius, *longest);
}

/// Largest distance of a --point from the surface, as a fraction of the diagonal of the bounding box.
constexpr double largest_distance = 0.05;

/// @throws Error (input) if the point is too far from the surface
void check_distance(const std::string& text, const SurfacePoint& place, const Mesh& mesh) {
  const double limit = largest_distance * (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm();
  if (place.distance <= limit) return;
  const auto& p = place.point;
  throw input_error(
      "a point is too far from the surface",
      fmt::format("--point {} is {:.4g} m away, the limit is {:.4g} m", text, place.distance, limit),
      fmt::format("points are in metres; the nearest one of the surface is {:.6g},{:.6g},{:.6g}", p[0], p[1], p[2]));
}

void select(const std::filesystem::path& continued, LoadedScene& loaded) {
  NodeList probed;
  if (std::filesystem::exists(continued)) {
    const auto header = read_database_header(continued);
    const bool same_mesh = header.mesh_hash == mesh_hash(loaded.mesh);
    if (same_mesh && header.physics_hash == physics_hash(loaded.scene)) {
      loaded.sets = header.sets;
      return select_elsewhere(loaded.scene, loaded.mesh, loaded.sets);
    }
    if (same_mesh) probed = header.sets.active;
  }
  resolve_selections(loaded.scene, loaded.mesh, loaded.sets, probed);
}

/// Reads a mesh of write_msh(). Its groups of cells are the regions; its groups of node sets are omitted.
MeshResult read_written_mesh(Scene scene, const std::filesystem::path& file) {
  const Scene whole = scene;
  MeshSpec spec;
  spec.file = file;
  spec.thickness_m = scene.mesh.thickness_m;
  spec.where = scene.mesh.where;
  scene.mesh = spec;
  scene.regions.clear();
  auto made = make_mesh(scene);
  take_written_regions(whole, made.mesh, file.string());
  std::erase_if(made.mesh.groups, [](const auto& group) { return group.first.starts_with("phynness_"); });
  return made;
}

void write_deformation(const ToolOptions& options, const Mesh& mesh, const ToolResult& result) {
  if (!options.deformation_csv) return;
  std::string csv = "node,x,y,z,ux,uy,uz";
  for (const auto& field : result.fields) csv += "," + field.heading;
  csv += "\n";
  for (std::size_t i = 0; i < result.nodes.size(); ++i) {
    const auto x = mesh.nodes.row(result.nodes[i]);
    const auto u = result.displacement_m.row(static_cast<Eigen::Index>(i));
    csv += fmt::format("{},{},{},{},{},{},{}", result.nodes[i], x[0], x[1], x[2], u[0], u[1], u[2]);
    for (const auto& field : result.fields) csv += fmt::format(",{}", field.values[static_cast<Eigen::Index>(i)]);
    csv += "\n";
  }
  write_text_file(*options.deformation_csv, csv);
  message("deformation of {} nodes: {}\n", result.nodes.size(), options.deformation_csv->string());
}

}  // namespace

std::vector<std::string_view> fields_of(std::string_view row) {
  std::vector<std::string_view> fields;
  for (std::size_t at = 0; at <= row.size();) {
    const auto end = std::min(row.find(',', at), row.size());
    auto field = row.substr(at, end - at);
    field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
    field.remove_suffix(field.size() - (field.find_last_not_of(' ') + 1));
    fields.push_back(field);
    at = end + 1;
  }
  return fields;
}

Scene open_scene(const std::filesystem::path& file) {
  auto scene = read_scene(file);
  if (scene.mesh.shape == Shape::none) declare_input("the mesh of " + file.string() + ",", scene.mesh.file);
  return scene;
}

LoadedScene load_scene(const std::filesystem::path& file, bool quiet,
                       const std::function<void(const LoadedScene&)>& refused, const std::filesystem::path& continued,
                       const std::filesystem::path& mesh_file) {
  LoadedScene loaded;
  loaded.scene = open_scene(file);
  quiet = quiet || !mesh_file.empty();
  auto made = mesh_file.empty() ? make_mesh(loaded.scene) : read_written_mesh(loaded.scene, mesh_file);
  if (!quiet) {
    for (const auto& note : made.notes) message("note: {}\n", note);
    for (const auto& note : scene_notes(loaded.scene)) message("note: {}\n", note);
    for (const auto& warning : made.warnings) message("warning: {}\n", warning);
    for (const auto& warning : scene_warnings(loaded.scene)) message("warning: {}\n", warning);
  }
  loaded.mesh = std::move(made.mesh);
  try {
    check_sizes(loaded.scene, made.quality, quiet);
    select(continued, loaded);
  } catch (const Error&) {
    if (refused) refused(loaded);
    throw;
  }
  if (!quiet) print_patch_warnings(loaded.scene, loaded.mesh, loaded.sets);
  return loaded;
}

std::optional<double> limit_of(const std::optional<std::string>& text, const char* option, const Units& units,
                               const char* example) {
  if (!text) return std::nullopt;
  double value = 0;
  const auto [end, code] = std::from_chars(text->data(), text->data() + text->size(), value);
  const auto unit = units.find(std::string(end, text->data() + text->size()));
  // A value of 1 or more without a unit is ambiguous: 2 may be a factor or percent.
  const bool is_ambiguous = unit != units.end() && unit->first.empty() && value >= 1;
  if (code != std::errc{} || unit == units.end() || !(value > 0) || is_ambiguous)
    throw input_error("a limit must be a positive number with a unit", fmt::format("{} {}", option, *text),
                      fmt::format("give for example {} {}", option, example));
  return value * unit->second;
}

json print_worst_cells(const Mesh& mesh, const NodeList& fixed) {
  const auto worst = worst_cells(mesh, fixed);
  if (!worst.empty()) print_result("worst cells\n");
  for (const auto& cell : worst) print_result("  {}\n", cell.str());
  return figures(worst);
}

json print_cells_across(const LoadedScene& loaded) {
  if (loaded.mesh.cells.cols() == 3) return nullptr;
  // The slab and the tube of docs/decisions/element.md, which are 0.8 and 0.4 thick, had the largest errors.
  constexpr double fewest = 1;
  const auto across = cells_across(loaded.mesh, loaded.sets.active);
  print_result("thickness {:.1f} mean cell edges below active nodes in the median, {:.1f} at least (node {})\n",
               across.median, across.least, across.thinnest);
  if (across.median < fewest)
    message(
        "warning: below most active nodes the body is less than one cell thick, so that forces may be far off: use "
        "smaller cells or taylor-hood; phynness check measures it\n");
  return figures(across);
}

void print_patch_warnings(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  for (const auto& warning : patch_warnings(scene, mesh, sets)) message("warning: {}\n", warning);
}

bool can_be_calibrated(const Model& model) {
  return !schema::traits(model.family).proportional && model.solved.is_recorded;
}

void print_missing_bounds(const Model& model) {
  if (can_be_calibrated(model)) print_result("it has no bounds of its errors; phynness calibrate adds them\n");
}

void print_choice_note(const LoadedScene& loaded) {
  if (const auto note = choice_note(loaded.scene, loaded.mesh, loaded.sets); !note.empty()) message("note: {}\n", note);
}

void check_mesh(const Scene& scene, const std::string& hash, const std::string& where) {
  if (scene.mesh.shape != Shape::none || !std::filesystem::exists(scene.mesh.file)) return;
  const auto scene_hash = mesh_hash(make_mesh(scene).mesh);
  if (scene_hash != hash)
    throw input_error("the mesh of " + where + " is not the mesh of the scene",
                      "hash " + hash + ", in the scene " + scene_hash,
                      "use the scene and mesh file from which it was made, or precompute again");
}

Database open_database(const Scene& scene, const std::filesystem::path& file) {
  const auto database = Database::open(file);
  const auto& header = database.header();
  if (header.imported)
    throw input_error(
        "imported responses belong to no scene", file.string(),
        "give phynness train this database only, without SCENE; other commands need a scene that was solved");
  if (physics_hash(scene) != header.physics_hash)
    require_same_rays(header, database_header(scene, header.mesh, header.sets), file);
  check_mesh(scene, header.mesh_hash, file.string());
  return database;
}

void print_log_damage(const std::vector<LogDamage>& all, const char* what) {
  for (const auto& damage : all)
    message("warning: {}: {}; {} {}\n", damage.log.string(), damage.reason, bytes(damage.dropped_bytes), what);
}

CLI::Validator finite_range(double low, double high) {
  const auto check = [low, high](std::string& text) {
    double value = 0;
    const bool number = CLI::detail::lexical_cast(text, value);
    if (number && value >= low && value <= high) return std::string();
    return fmt::format("'{}' is not a number from {:g} to {:g}", text, low, high);
  };
  return CLI::Validator(check, fmt::format("FLOAT in [{:g} - {:g}]", low, high));
}

void write_json(const OptionalPath& file, const json& value) {
  if (!file) return;
  if (is_stdout(*file))
    write_stdout(value.dump(2) + "\n");
  else
    write_text_file(*file, value.dump(2) + "\n");
}

void add_scene(CLI::App& command, std::filesystem::path& file, const char* what) {
  add_path(command, "SCENE", file, PathKind::input, what)->required();
}
void add_made_mesh(CLI::App& command, std::filesystem::path& file) {
  add_path(command, "--mesh", file, PathKind::input,
           "file that phynness mesh has written of SCENE: the mesh is not made again");
}
void add_database(CLI::App& command, std::filesystem::path& file, const char* what) {
  add_path(command, "DATABASE", file, PathKind::input, what)->required();
}
void add_model(CLI::App& command, std::filesystem::path& folder) {
  add_path(command, "MODEL_DIR", folder, PathKind::input, "directory with model.txt and mesh.txt")->required();
}
void add_output(CLI::App& command, std::filesystem::path& place, PathKind kind, const char* what) {
  add_path(command, "-o,--output", place, kind, what)->required();
}
void add_json(CLI::App& command, OptionalPath& file, const char* what) {
  add_path(command, "--json", file, PathKind::file, what);
}

void ToolOptions::add_to(CLI::App& command) {
  command.add_option("--node", nodes, "number of the touched node, starting with 0; repeat for several tools")
      ->allow_extra_args(false);
  command
      .add_option(
          "--point", points,
          fmt::format("touched point x,y,z [m] instead of a node; the nearest point of the undeformed surface is "
                      "used, at most {:g} % of the body's diagonal away; repeat for several tools",
                      100 * largest_distance))
      ->allow_extra_args(false);
  command
      .add_option("--displacement", displacements,
                  "displacement dx,dy,dz [m]; one for each --node, then one for each --point")
      ->allow_extra_args(false);
  add_path(command, "--deformation", deformation_csv, PathKind::file,
           "write a CSV file with the displacement of the output nodes: node,x,y,z,ux,uy,uz [m] and scalar fields");
  add_json(command, json_file, "write the result as JSON");
}

std::vector<Vec3> ToolOptions::parsed_displacements() const {
  if (nodes.empty() && points.empty())
    throw input_error("a tool is missing", "neither --node nor --point is given",
                      "give for example --node 5 --displacement 0,0,-0.01");
  if (nodes.size() + points.size() != displacements.size())
    throw input_error(
        "each --node and --point needs one --displacement",
        fmt::format("{} nodes, {} points, {} displacements", nodes.size(), points.size(), displacements.size()),
        "repeat both options: --node 5 --displacement 0,0,-0.01 --node 9 --displacement 0,0.005,0");
  std::vector<Vec3> parsed;
  for (const auto& text : displacements)
    parsed.push_back(parse_vector(text, "displacement", "give for example --displacement 0,0,-0.01 (in metres)"));
  return parsed;
}

std::vector<SurfacePoint> ToolOptions::places(const Mesh& mesh) const {
  std::vector<SurfacePoint> places;
  for (const auto node : nodes) {
    if (node < 0 || node >= mesh.n_nodes())
      throw input_error("the mesh has no such node", "--node " + std::to_string(node),
                        "give a number from 0 to " + std::to_string(mesh.n_nodes() - 1));
    SurfacePoint place = at_node(node);
    for (int k = 0; k < 3; ++k) place.point[static_cast<std::size_t>(k)] = mesh.nodes(node, k);
    places.push_back(place);
  }
  for (const auto& text : points) {
    const Vec3 position = parse_vector(text, "point", "give for example --point 0.1,0.02,0.05 (in metres)");
    places.push_back(nearest_on_surface(mesh.nodes, mesh.surface, position));
    const auto& place = places.back();
    check_distance(text, place, mesh);
    message("note: point {} is {:.3g} m from the surface; the nearest triangle has the nodes {}, {}, {}\n", text,
            place.distance, place.nodes[0], place.nodes[1], place.nodes[2]);
  }
  return places;
}

void report_tools(const ToolOptions& options, const std::vector<SurfacePoint>& places,
                  const std::vector<Vec3>& displacements, const Mesh& mesh, const ToolResult& result, json extra,
                  const std::function<void()>& write_more) {
  std::optional<double> largest;
  if (result.displacement_m.rows() > 0) largest = result.displacement_m.rowwise().norm().maxCoeff();
  json tools = json::array();
  for (std::size_t t = 0; t < places.size(); ++t) {
    const auto &d = displacements[t], &p = places[t].point;
    const auto& f = result.force_N[t];
    const bool at_node = t < options.nodes.size();
    tools.push_back(at_node ? record("node", options.nodes[t])
                            : record("node", nullptr, "point", p, "distance", places[t].distance, "nodes",
                                     places[t].nodes, "weights", places[t].weights));
    tools.back().update(record("displacement", d, "force", f));
    print_result("{}  displacement {:g} {:g} {:g} m",
                 at_node ? fmt::format("node {}", options.nodes[t])
                         : fmt::format("point {:.6g} {:.6g} {:.6g} m", p[0], p[1], p[2]),
                 d[0], d[1], d[2]);
    print_result("  force{}\n", f ? fmt::format(" {:.6g} {:.6g} {:.6g} N", (*f)[0], (*f)[1], (*f)[2])
                                  : ": undefined with --tools paper");
  }
  json out = record("tools", tools, "energy", result.energy_J, "max_displacement", largest);
  out.update(extra);
  if (result.energy_J) print_result("energy {:.6g} J  ", *result.energy_J);
  if (largest)
    print_result("largest displacement {:.6g} m\n", *largest);
  else
    print_result("no deformation: the model has forces only\n");
  for (const auto& field : result.fields) {
    const double largest_value = field.values.size() > 0 ? field.values.maxCoeff() : 0.0;
    print_result("largest {} {:.6g} {}\n", field.name, largest_value, field.unit);
    out["fields"][field.name] = record("max", largest_value, "unit", field.unit);
  }

  write_each({[&] { write_deformation(options, mesh, result); }, [&] { write_json(options.json_file, out); },
              [&] {
                if (write_more) write_more();
              }});
}

}  // namespace phynness::cli
