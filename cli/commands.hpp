// The subcommands. Each adds itself to the command line; what it does runs when the line has been parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
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
namespace run_command {
void add(CLI::App& app);
}

/// Reads a scene and declares the mesh file that it names as an input of the command.
/// @throws Error also if an output would overwrite that file
Scene open_scene(const std::filesystem::path& file);

/// A scene with its mesh and selections; says on stderr what was noted on the way.
struct LoadedScene {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
};
LoadedScene load_scene(const std::filesystem::path& file, bool quiet = false);

/// @throws Error if the scene's mesh specification cannot be the one `mesh` came from: a file mesh is read
/// and its hash compared, a built-in shape is compared by its specification (a remesh by another gmsh is
/// another mesh).
void check_mesh(const Scene& scene, const std::string& mesh_hash, const std::string& where);

/// For options: a finite number from `low` to `high`; CLI11's own ranges let nan pass.
CLI::Validator finite_range(double low, double high);

void write_json(const std::optional<std::filesystem::path>& file, const json& value);

/// Far beyond every body that the mesh checks let pass without a warning, far below where squares overflow.
inline constexpr double largest_displacement_m = 1e6;

/// Of a body with this diagonal: solves in double precision have some four digits of the force at this displacement,
/// and none at a ten-thousandth of it.
inline double smallest_displacement(double diagonal_m) { return 1e-12 * diagonal_m; }

/// Tools from repeated --node J or --point x,y,z and --displacement dx,dy,dz.
struct ToolOptions {
  std::vector<std::int32_t> nodes;
  std::vector<std::string> points, displacements;
  std::optional<std::filesystem::path> deformation_csv, json_file;
  void add_to(CLI::App& command);
  /// Of the tools at nodes, then of those at points.
  /// @throws Error unless there are as many displacements as tools, at least one, each three finite numbers
  std::vector<Vec3> parsed_displacements() const;
  /// Where the tools are: nodes, then the points of the surface nearest to --point; says how far they moved.
  /// @throws Error if a point is no three finite numbers or a node is none of the mesh
  std::vector<SurfacePoint> places(const Mesh& mesh) const;
};

/// The result that eval and solve share.
struct ToolResult {
  std::vector<std::optional<Vec3>> force_N;
  std::optional<double> energy_J;
  Points displacement_m;            ///< one row per entry of `nodes`
  std::vector<std::int32_t> nodes;  ///< mesh node numbers of the rows
  struct Column {
    std::string name, unit, heading;  ///< heading: of a table, unit included
    Eigen::VectorXd values;           ///< one per entry of `nodes`
  };
  std::vector<Column> fields;
};
void report_tools(const ToolOptions& options, const std::vector<SurfacePoint>& places,
                  const std::vector<Vec3>& displacements, const Mesh& mesh, const ToolResult& result, json extra);

}  // namespace phynness::cli
