// The subcommands. Each function adds a subcommand, which is executed after the whole command line has been parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <phynness/formats/tool.hpp>
#include <string>
#include <vector>

namespace phynness::cli {

using json = nlohmann::ordered_json;

// One namespace per command, in a file of the same name.
namespace mesh_command {
void add(CLI::App& app);
}
namespace plan_command {
void add(CLI::App& app);
}
namespace precompute_command {
void add(CLI::App& app);
}
namespace merge_command {
void add(CLI::App& app);
}
namespace train_command {
void add(CLI::App& app);
}
namespace calibrate_command {
void add(CLI::App& app);
}
namespace validate_command {
void add(CLI::App& app);
}
namespace tune_command {
void add(CLI::App& app);
}
namespace eval_command {
void add(CLI::App& app);
}
namespace bench_command {
void add(CLI::App& app);
}
namespace check_command {
void add(CLI::App& app);
}
namespace solve_command {
void add(CLI::App& app);
}
namespace export_command {
void add(CLI::App& app);
}
namespace info_command {
void add(CLI::App& app);
}
namespace show_command {
void add(CLI::App& app);
}
namespace view_command {
void add(CLI::App& app);
}
namespace run_command {
void add(CLI::App& app);
}

/// Executes the program with the solver instead of this one, if it is another one and has the subcommand argv[1].
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
/// @param refused  called with the mesh, and with the sets selected so far, before an error about them leaves
LoadedScene load_scene(const std::filesystem::path& file, bool quiet = false,
                       const std::function<void(const LoadedScene&)>& refused = {});

/// Prints patch_warnings() on stderr. load_scene does it; others that read a database do it themselves.
void warn_of_patch(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// Checks that a mesh belongs to the scene. Only a mesh file is compared, by its hash. Built-in shapes are covered by
/// the physics hash, because another version of gmsh makes another mesh.
/// @param where  the file with `mesh_hash`, for messages
/// @throws Error (input) if the hashes differ
void check_mesh(const Scene& scene, const std::string& mesh_hash, const std::string& where);

/// For options: a finite number from `low` to `high`; CLI11's own ranges let nan pass.
CLI::Validator finite_range(double low, double high);

/// Of an option --json; "-" is stdout.
void write_json(const std::optional<std::filesystem::path>& file, const json& value);

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
  std::optional<double> max_distance_m;  ///< of a --point from the surface; by default part of the body's size
  std::optional<std::filesystem::path> deformation_csv, json_file;
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
