#include <numeric>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/vtk.hpp>
#include <phynness/meshes/meshes.hpp>

#include "commands.hpp"

namespace phynness::cli::mesh_command {
namespace {

struct Options {
  std::filesystem::path scene, output;
  OptionalPath json_file;
};

/// Writes a mesh with its node sets, for ParaView (.vtu) or gmsh.
void write_mesh(const LoadedScene& loaded, const std::filesystem::path& file) {
  if (file.extension() != ".vtu") return write_msh(loaded.mesh, &loaded.sets, file);
  VtkGrid grid{loaded.mesh.nodes, loaded.mesh.cells, {}, loaded.mesh.regions};
  grid.node_numbers.resize(static_cast<std::size_t>(loaded.mesh.n_nodes()));
  std::iota(grid.node_numbers.begin(), grid.node_numbers.end(), 0);
  VtkState state;
  for (const auto& [name, nodes] :
       {std::pair{"fixed", &loaded.sets.fixed}, {"active", &loaded.sets.active}, {"output", &loaded.sets.output}}) {
    Eigen::MatrixXd is_in_set = Eigen::MatrixXd::Zero(loaded.mesh.n_nodes(), 1);
    is_in_set(*nodes, 0).setOnes();
    state.fields.push_back({name, std::move(is_in_set)});
  }
  write_text_file(file, vtu_text(grid, state));
}

void run(const Options& options) {
  if (const auto ending = options.output.extension(); ending != ".vtu" && ending != ".msh")
    throw input_error("the format of the mesh to write is unknown", options.output.string(),
                      "give a name that ends in .vtu (ParaView) or .msh (gmsh)");
  const auto loaded = load_scene(options.scene, false, [&](const LoadedScene& refused) {
    if (std::filesystem::exists(options.output)) {
      message("note: {} is left as it was; with a name of no file, -o writes the refused mesh to look at\n",
              options.output.string());
      return;
    }
    write_mesh(refused, options.output);
    message("note: {} is written to look at, with the groups of the node sets selected so far\n",
            options.output.string());
  });
  print_choice_note(loaded);
  const auto q = measure_quality(loaded.mesh);
  const auto& s = loaded.sets;
  const bool shell = loaded.mesh.cells.cols() == 3;
  if (shell)
    print_result("{} nodes, {} triangles of a shell {:.3g} mm thick, {:.4g} cm2", q.n_nodes, q.n_cells,
                 1e3 * loaded.scene.mesh.thickness_m, 1e4 * q.area_m2);
  else
    print_result("{} nodes ({} on the surface), {} tetrahedra, {:.4g} cm3", q.n_nodes, q.n_surface_nodes, q.n_cells,
                 1e6 * q.volume_m3);
  print_result(", x {:.3g} to {:.3g}, y {:.3g} to {:.3g}, z {:.3g} to {:.3g} mm\n", 1e3 * q.min_m[0], 1e3 * q.max_m[0],
               1e3 * q.min_m[1], 1e3 * q.max_m[1], 1e3 * q.min_m[2], 1e3 * q.max_m[2]);
  print_result("edges {:.3g} to {:.3g} mm, mean {:.3g} mm; {} slivers with quality below {}\n", 1e3 * q.min_edge_m,
               1e3 * q.max_edge_m, 1e3 * q.mean_edge_m, q.n_slivers, sliver_quality);
  const json worst = print_worst_cells(loaded.mesh, s.fixed);
  print_result("{} fixed nodes, {} active, {} output\n", s.fixed.size(), s.active.size(), s.output.size());
  const json across = print_cells_across(loaded);
  const json figures =
      record("mesh_hash", mesh_hash(loaded.mesh), "nodes", q.n_nodes, "tetrahedra", shell ? 0 : q.n_cells,
             "shell_triangles", shell ? q.n_cells : 0, "surface_nodes", q.n_surface_nodes, "surface_triangles",
             q.n_surface_triangles, "volume_m3", shell ? q.area_m2 * loaded.scene.mesh.thickness_m : q.volume_m3,
             "min_quality", q.min_quality, "worst_cells", worst, "slivers", q.n_slivers, "mean_edge_m", q.mean_edge_m,
             "cells_across", across, "fixed", s.fixed.size(), "active", s.active.size(), "output", s.output.size());
  write_each({[&] {
                write_mesh(loaded, options.output);
                print_result("mesh {} -> {}\n", mesh_hash(loaded.mesh), options.output.string());
              },
              [&] { write_json(options.json_file, figures); }});
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(app, "mesh", "Generate or import the mesh of a scene, check it, write it", run);
  add_scene(command, options.scene, "scene file (formats/scene.md)");
  add_output(command, options.output, PathKind::file,
             "mesh file to write: .vtu for ParaView, .msh for gmsh (format 4.1)");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::mesh_command
