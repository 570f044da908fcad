#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/error.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "eval_motion.hpp"
#include "eval_queries.hpp"
#include "eval_refusals.hpp"
#include "fine_surface.hpp"
#include "streams.hpp"

namespace phynness::cli::eval_command {
namespace {

struct Options {
  std::filesystem::path model;
  std::string tools = "coupled";
  ToolOptions tool;
  std::optional<std::filesystem::path> surface;
  int levels = 0;  ///< of subdivision
  std::optional<std::int32_t> level;
  std::optional<std::filesystem::path> queries, motion;
};

void check_surface_options(const Options& options) {
  if (!options.surface) {
    if (options.levels > 0)
      throw input_error("--subdivide needs --surface", fmt::format("--subdivide {}", options.levels),
                        "add --surface file.vtk");
    return;
  }
  check_surface_name(*options.surface);
}

std::vector<phn_tool> tools_at(const std::vector<SurfacePoint>& places, const std::vector<Vec3>& displacements) {
  std::vector<phn_tool> tools;
  for (std::size_t t = 0; t < places.size(); ++t) {
    phn_tool& tool = tools.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      tool.nodes[k] = places[t].nodes[k];
      tool.weights[k] = places[t].weights[k];
      tool.displacement[k] = displacements[t][k];
    }
  }
  return tools;
}

/// Of every tool that is displaced farther than a node below it was trained: both lengths. "": the status says no such
/// thing.
std::string lengths_outside(const LoadedModel& model, int status, const std::vector<SurfacePoint>& places,
                            const std::vector<Vec3>& displacements) {
  std::string text;
  if ((status & PHN_WARNING_OUTSIDE) == 0) return text;
  const auto active = model.runtime().active_nodes();
  for (std::size_t t = 0; t < places.size(); ++t) {
    const Vec3& d = displacements[t];
    const double length_m = std::hypot(d[0], d[1], d[2]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = places[t].nodes[k];
      if (places[t].weights[k] == 0 || std::find(active.begin(), active.end(), node) == active.end()) continue;
      const double trained_m = model.trained_depth(node, d);
      if (length_m > trained_m)
        text += fmt::format("\n  {:.4g} m at node {}, trained to {:.4g} m in its direction", length_m, node, trained_m);
    }
  }
  return text;
}

/// --queries replaces the options of a single query, and its result is a table.
void run_queries(const Options& options) {
  const auto& tool = options.tool;
  if (!tool.nodes.empty() || !tool.points.empty() || !tool.displacements.empty())
    throw input_error("--queries excludes tools on the command line",
                      "--queries together with --node, --point or --displacement",
                      "omit either --queries or the tools");
  if (tool.deformation_csv || tool.json_file || options.surface || options.levels > 0)
    throw input_error("--queries only writes a table to stdout",
                      "--queries together with --json, --deformation, --surface or --subdivide",
                      "redirect stdout to a file, or use these options for one query with --node");
  LoadedModel model(options.model);
  if (options.level) model.set_level(*options.level);
  answer_queries(model, *options.queries);
}

std::vector<SurfacePoint> places_of(const Motion& motion, const std::string& name, const Mesh& mesh) {
  std::vector<SurfacePoint> places;
  for (const auto& tool : motion.tools) {
    SurfacePoint place{tool.nodes, tool.weights, {}, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      if (tool.nodes[k] >= mesh.n_nodes())
        throw input_error(name + ": the mesh has no such node", std::to_string(tool.nodes[k]),
                          "give the model for which the motion was recorded; its nodes are 0 to " +
                              std::to_string(mesh.n_nodes() - 1));
      for (int c = 0; c < 3 && tool.nodes[k] >= 0; ++c)
        place.point[static_cast<std::size_t>(c)] += tool.weights[k] * mesh.nodes(tool.nodes[k], c);
    }
    places.push_back(place);
  }
  return places;
}

/// --motion replaces the options of a single query, except --json.
void run_motion(const Options& options) {
  const auto& tool = options.tool;
  if (!tool.nodes.empty() || !tool.points.empty() || !tool.displacements.empty())
    throw input_error("--motion excludes tools on the command line",
                      "--motion together with --node, --point or --displacement", "omit either --motion or the tools");
  if (options.queries || tool.deformation_csv || options.surface || options.levels > 0 || options.tools == "paper")
    throw input_error("--motion only writes forces",
                      "--motion together with --queries, --deformation, --surface, --subdivide or --tools paper",
                      "use --json for the forces, or these options for one query with --node");
  const auto name = options.motion->string();
  const auto motion = read_motion(*options.motion);
  LoadedModel model(options.model);
  if (options.level) model.set_level(*options.level);
  refuse_as_solve(model, places_of(motion, name, model.mesh()));
  answer_motion(model, motion, name, tool.json_file);
}

void print_bound(const LoadedModel& model, const std::optional<double>& bound_N) {
  if (bound_N)
    print_result("error of the force: at most {:.3g} N for {:g} % of random displacements\n", *bound_N,
                 100 * model.model().bounds.at(0).coverage);
  else
    print_result("error of the force: unknown outside of the trained range\n");
}

void run(const Options& options) {
  check_surface_options(options);
  const auto displacements = options.tool.parsed_displacements();
  if (options.tools == "paper" && !options.tool.points.empty())
    throw input_error("--tools paper is only defined for tools at nodes", "--point " + options.tool.points.front(),
                      "use --tools coupled, or use --node");
  LoadedModel model(options.model);
  if (options.level) model.set_level(*options.level);
  const auto places = options.tool.places(model.mesh());
  refuse_as_solve(model, places);
  const bool coupled = options.tools == "coupled" && (places.size() > 1 || !options.tool.points.empty());
  const auto response =
      coupled ? model.couple(tools_at(places, displacements)) : model.respond(options.tool.nodes, displacements);
  const auto& wanted = options.tool.deformation_csv ? options.tool.deformation_csv : options.surface;
  if (response.displacement_m.rows() == 0 && wanted)
    throw input_error("this model has forces only", wanted->string(),
                      "omit the output file, or train the model with [training] modes of 1 or more");
  if (response.status > 0)
    message("warning: {}{}\n", phn_status_message(response.status),
            lengths_outside(model, response.status, places, displacements));
  json extra{{"status", response.status}, {"family", model.runtime().info().family}, {"level", model.data().level()}};
  const bool single = !coupled && places.size() == 1, bounded = single && model.has_bounds();
  std::optional<double> bound_N;
  if (single) {
    const auto node = options.tool.nodes.front();
    extra["trained_distance"] = model.trained_distance(node, displacements.front());
    if (bounded) bound_N = model.error_bound(node, displacements.front());
  }
  if (bounded) extra["bound_N"] = bound_N ? json(*bound_N) : json(nullptr);
  if (coupled) {
    extra["residual"] = response.coupled.residual;
  }
  const auto& info = model.runtime().info();
  const auto output = model.runtime().output_nodes();
  ToolResult result{response.force_N, response.energy_J, response.displacement_m, {output.begin(), output.end()}, {}};
  for (Eigen::Index f = 0; f < response.fields.cols(); ++f) {
    const std::string field = info.field_names[f];
    const auto known = field_named(field);
    result.fields.push_back({field, info.field_units[f], known ? column(*known) : field, response.fields.col(f)});
  }
  report_tools(options.tool, places, displacements, model.mesh(), result, extra, [&] {
    if (!options.surface) return;
    const auto n = write_fine_surface(model, response.displacement_m, options.levels, *options.surface, info.title);
    message("surface of {} vertices: {}\n", n, options.surface->string());
  });
  if (bounded) print_bound(model, bound_N);
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("eval", "Compute force and deformation from a model with the runtime");
  add_path(*command, "MODEL_DIR", options->model, InputKind::whole, "directory with model.txt and mesh.txt")
      ->required();
  options->tool.add_to(*command);
  command->get_option("--displacement")->required(false);  // the file of --queries contains displacements
  add_path(
      *command, "--queries", options->queries, InputKind::whole,
      fmt::format("CSV file of many queries, instead of --node; its first line is {}; prints a CSV table of forces",
                  queries_header));
  add_path(*command, "--motion", options->motion, InputKind::whole,
           "JSON file of a recorded motion of tools (formats/motion.md), instead of --node; --json writes its forces");
  command
      ->add_option("--tools", options->tools,
                   "method for several tools: coupled (with forces), or paper (weights (15)-(16), without forces)")
      ->check(CLI::IsMember({"coupled", "paper"}));
  command->add_option("--level", options->level, "level of the model; 0 is the smallest (default: the full one)");
  add_path(*command, "--surface", options->surface, OutputKind::file,
           "write the surface: undeformed with its displacement (.vtk, .vtu) or deformed (.obj)");
  command->add_option("--subdivide", options->levels, "levels of subdivision of that surface (Loop's scheme)")
      ->check(CLI::Range(0, 6));
  command->callback([options] {
    if (options->motion) return run_motion(*options);
    options->queries ? run_queries(*options) : run(*options);
  });
}

}  // namespace phynness::cli::eval_command
