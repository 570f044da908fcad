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

/// The message of a JSON error without the name of the exception in front of it.
std::string problem_of(const json::exception& error);

// Each command is a file NAME_command.cpp with a namespace of that name. The first list has the order of --help. The
// commands of the second list need dolfinx and are in the program with the solver.
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

/// Adds a subcommand. @param run  is called with the options after the command line has been parsed
template <class Options>
std::pair<CLI::App&, Options&> add_command(CLI::App& app, const char* name, const std::string& about,
                                           void (*run)(const Options&)) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand(name, about);
  command->callback([options, run] { run(*options); });
  return {*command, *options};
}

// Options of several commands. SCENE, DATABASE, MODEL_DIR and --output are required.
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
/// Parses a limit: "2%" with the units {{"%", 0.01}, {"", 1}} is 0.02. @throws Error (input)
std::optional<double> limit_of(const std::optional<std::string>& text, const char* option, const Units& units,
                               const char* example);

/// Replaces this process by the program with the solver if argv[1] is a subcommand that uses the solver, and if this
/// program has none.
/// @throws Error (failure) if it cannot be started
void exec_solver_program(char** argv);

/// Reads a scene and declares its mesh file as an input of the command.
/// @throws Error (input) if the scene is invalid or if an output of the command would overwrite the mesh file
Scene open_scene(const std::filesystem::path& file);

/// A scene with its mesh and node sets.
struct LoadedScene {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
};
/// Loads a scene and prints notes and warnings on stderr unless `quiet`.
/// @param refused    is called with the mesh and the sets selected so far before an error about them is thrown
/// @param continued  database that --resume continues; its spread points are kept if it exists
/// @param made       mesh file of `phynness mesh`, which replaces the generation of the mesh without messages; or empty
LoadedScene load_scene(const std::filesystem::path& file, bool quiet = false,
                       const std::function<void(const LoadedScene&)>& refused = {},
                       const std::filesystem::path& continued = {}, const std::filesystem::path& made = {});
/// Adds the option for `made`.
void add_made_mesh(CLI::App& command, std::filesystem::path& file);

/// Prints the worst cells of a mesh, one per line. @return their figures
json print_worst_cells(const Mesh& mesh, const NodeList& fixed);

/// Prints how many cells lie across the body below the active nodes; too few are a warning. @return the figures
json print_cells_across(const LoadedScene& loaded);

/// Prints patch_warnings() on stderr, as load_scene() does.
void print_patch_warnings(const Scene& scene, const Mesh& mesh, const NodeSets& sets);
/// Prints choice_note() on stderr.
void print_choice_note(const LoadedScene& loaded);
/// Whether `calibrate` adds bounds: not to a model of an exact family, or of responses of another program.
bool can_be_calibrated(const Model& model);
/// Says that such a model was written without bounds.
void print_missing_bounds(const Model& model);

/// Checks by its hash that a mesh file belongs to the scene. Built-in shapes are covered by the physics hash, because
/// their meshes depend on the version of gmsh.
/// @param where  file that contains `mesh_hash`, for messages
/// @throws Error (input) if the hashes differ
void check_mesh(const Scene& scene, const std::string& mesh_hash, const std::string& where);

/// Opens the database of a scene, or of another scene that contains all its rays, with its active and output nodes.
/// header() is that of the scene's own database.
/// @throws Error (input) with the differences if the database does not have all rays of the scene
Database open_database(const Scene& scene, const std::filesystem::path& file);

/// Prints the damage of the logs of a database. @param what  consequence for the damaged bytes
void print_log_damage(const std::vector<LogDamage>& all, const char* what = "are ignored");

/// Writes the file of the option --json; "-" is stdout.
void write_json(const OptionalPath& file, const json& value);

/// Larger than any body that passes the mesh checks without a warning; its square does not overflow.
inline constexpr double largest_displacement_m = 1e6;

/// The displacement at which forces of a body with this diagonal have about four digits in double precision; they have
/// none at a ten-thousandth of it.
inline double smallest_displacement(double diagonal_m) { return 1e-12 * diagonal_m; }

/// Tools from repeated --node J or --point x,y,z and --displacement dx,dy,dz.
struct ToolOptions {
  std::vector<std::int32_t> nodes;
  std::vector<std::string> points, displacements;
  OptionalPath deformation_csv, json_file;
  void add_to(CLI::App& command);
  /// Displacements [m] of the tools at nodes, followed by those of the tools at points.
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
    std::string name, unit, heading;  ///< heading of the CSV column, with the unit
    Eigen::VectorXd values;           ///< one per entry of `nodes`
  };
  std::vector<Column> fields;
};
/// Prints the result, writes the files of `options`, and calls `write_more`.
void report_tools(const ToolOptions& options, const std::vector<SurfacePoint>& places,
                  const std::vector<Vec3>& displacements, const Mesh& mesh, const ToolResult& result, json extra,
                  const std::function<void()>& write_more = {});

}  // namespace phynness::cli
