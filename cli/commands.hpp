// The subcommands. Each function adds a subcommand, which is executed after the whole command line has been parsed.
#pragma once

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/figures.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/scene.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command_files.hpp"
#include "console.hpp"

namespace phynness::cli {

using json = Json;

/// An object of keys and values, as in record("nodes", 4, "error", error); figures() of the values.
template <class Value, class... More>
json record(const char* key, const Value& value, const More&... more) {
  json out = json::object();
  out[key] = figures(value);
  if constexpr (sizeof...(more) > 0) out.update(record(more...));
  return out;
}

// Each command is a file NAME_command.cpp with a namespace of that name, in the order of --help. Those of the second
// list need dolfinx and are in the program with the solver.
#define PHYNNESS_COMMANDS(each)                                                                                  \
  each(mesh) each(check) each(plan) each(precompute) each(import) each(train) each(reduce) each(calibrate)       \
      each(validate) each(tune) each(eval) each(bench) each(solve) each(export) each(info) each(show) each(view) \
          each(run)
#define PHYNNESS_SOLVER_COMMANDS(each) \
  each(plan) each(precompute) each(calibrate) each(validate) each(tune) each(check) each(solve) each(run)
#define PHYNNESS_DECLARE(name) \
  namespace name##_command {   \
    void add(CLI::App& app);   \
  }
PHYNNESS_COMMANDS(PHYNNESS_DECLARE)

/// Adds a subcommand. @param run  executed with the options after the whole command line has been parsed
template <class Options>
std::pair<CLI::App&, Options&> add_command(CLI::App& app, const char* name, const std::string& about,
                                           void (*run)(const Options&)) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(name, about);
  command->callback([options, run] { run(*options); });
  return {*command, *options};
}

// Options that several commands have. Those of SCENE, DATABASE, MODEL_DIR and --output are required.
using OptionalPath = std::optional<std::filesystem::path>;
CLI::Validator finite_range(double low, double high);
void add_scene(CLI::App& command, std::filesystem::path& file, const char* what = "scene file");
void add_database(CLI::App& command, std::filesystem::path& file, const char* what);
void add_model(CLI::App& command, std::filesystem::path& folder);
void add_output(CLI::App& command, std::filesystem::path& place, PathKind kind, const char* what);
void add_json(CLI::App& command, OptionalPath& file, const char* what = "write the figures as JSON");
/// An integer from `low` to `high`.
template <class Value>
CLI::Option* add_count(CLI::App& command, const char* name, Value& value, std::int64_t low, std::int64_t high,
                       const std::string& what) {
  return command.add_option(name, value, what)->check(CLI::Range(low, high));
}
inline constexpr auto largest_seed = std::numeric_limits<std::int64_t>::max();
/// A finite number from `low` to `high`; CLI11's own ranges let nan pass.
template <class Value>
CLI::Option* add_number(CLI::App& command, const char* name, Value& value, double low, double high,
                        const std::string& what) {
  return command.add_option(name, value, what)->check(finite_range(low, high));
}

/// Values between commas, without surrounding spaces.
std::vector<std::string_view> fields_of(std::string_view row);
/// @return false unless the whole field is a number; numbers that are too small are 0
template <class Number>
bool parse_number(std::string_view field, Number& number) {
  if (field.starts_with('+')) field.remove_prefix(1);
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), number);
  const bool small =
      code == std::errc::result_out_of_range && (field.find("e-") != field.npos || field.find("E-") != field.npos);
  if (small) number = {};
  return (small || code == std::errc{}) && end == field.data() + field.size();
}

using Units = std::map<std::string, double>;
/// A limit of the command line: "2%" with the units {{"%", 0.01}, {"", 1}} is 0.02. @throws Error (input)
std::optional<double> limit_of(const std::optional<std::string>& text, const char* option, const Units& units,
                               const char* example);

/// Executes the program with the solver instead of this one, if it is another one and argv[1] is a subcommand that
/// needs it or, as reduce, does more with it.
/// @throws Error (failure) if it cannot be started
void leave_to_solver(char** argv);

/// Reads a scene and declares the mesh file that it names as an input of the command.
/// @throws Error (input) if the scene is invalid or if an output of the command would overwrite the mesh file
Scene open_scene(const std::filesystem::path& file);

/// A scene with its mesh and node sets. load_scene prints notes and warnings on stderr unless `quiet`.
struct LoadedScene {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
};
/// @param refused    called with the mesh, and with the sets selected so far, before an error about them leaves
/// @param continued  a database that --resume continues, if it exists: spread points keep those that it has
/// @param made       the mesh as `mesh` has written it, which is then not made again, and nothing is printed; or empty
LoadedScene load_scene(const std::filesystem::path& file, bool quiet = false,
                       const std::function<void(const LoadedScene&)>& refused = {},
                       const std::filesystem::path& continued = {}, const std::filesystem::path& made = {});
/// The option for it.
void add_made_mesh(CLI::App& command, std::filesystem::path& file);

/// Prints the worst cells of a mesh in a line each. @return their figures
json tell_worst_cells(const Mesh& mesh, const NodeList& fixed);

/// Prints patch_warnings() on stderr. load_scene does it; others that read a database do it themselves.
void warn_of_patch(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// Checks that a mesh belongs to the scene. Only a mesh file is compared, by its hash. Built-in shapes are covered by
/// the physics hash, because another version of gmsh makes another mesh.
/// @param where  the file with `mesh_hash`, for messages
/// @throws Error (input) if the hashes differ
void check_mesh(const Scene& scene, const std::string& mesh_hash, const std::string& where);

/// Opens the database of a scene, or of another scene that has all its rays, of which some active and output nodes are
/// taken. header() is that of the scene's own database.
/// @throws Error (input) with the differences if the database does not have all rays of the scene
Database open_database(const Scene& scene, const std::filesystem::path& file);

/// Prints what is lost of the logs of a database. @param what  becomes of it
void warn_of_damage(const std::vector<LogDamage>& all, const char* what = "are ignored");

/// Of an option --json; "-" is stdout.
void write_json(const OptionalPath& file, const json& value);

/// Much larger than any body that passes the mesh checks without a warning, and much smaller than numbers whose squares
/// overflow.
inline constexpr double largest_displacement_m = 1e6;

/// Of a body with this diagonal: solves in double precision have some four digits of the force at this displacement,
/// and none at a ten-thousandth of it.
inline double smallest_displacement(double diagonal_m) { return 1e-12 * diagonal_m; }

/// Tools from repeated --node J or --point x,y,z and --displacement dx,dy,dz.
struct ToolOptions {
  std::vector<std::int32_t> nodes;
  std::vector<std::string> points, displacements;
  OptionalPath deformation_csv, json_file;
  void add_to(CLI::App& command);
  /// Displacements [m] of the tools at nodes, then of the tools at points.
  /// @throws Error (input) unless there is at least one tool and one displacement of three finite numbers for each tool
  std::vector<Vec3> parsed_displacements() const;
  /// Positions of the tools: the nodes, then the surface points nearest to each --point, whose distances are printed on
  /// stderr.
  /// @throws Error (input) if a point is not three finite numbers or too far from the surface, or a node is not in the
  /// mesh
  std::vector<SurfacePoint> places(const Mesh& mesh) const;
};

/// The result of eval and of solve.
struct ToolResult {
  std::vector<std::optional<Vec3>> force_N;
  std::optional<double> energy_J;
  Points displacement_m;            ///< one row per entry of `nodes`
  std::vector<std::int32_t> nodes;  ///< mesh node numbers of the rows
  struct Column {
    std::string name, unit, heading;  ///< heading: of the CSV column, including the unit
    Eigen::VectorXd values;           ///< one per entry of `nodes`
  };
  std::vector<Column> fields;
};
/// Prints the result and writes the files of `options`, and then what `write_more` writes.
void report_tools(const ToolOptions& options, const std::vector<SurfacePoint>& places,
                  const std::vector<Vec3>& displacements, const Mesh& mesh, const ToolResult& result, json extra,
                  const std::function<void()>& write_more = {});

}  // namespace phynness::cli
