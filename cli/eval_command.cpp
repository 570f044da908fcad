#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/error.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "eval_motion.hpp"
#include "fine_surface.hpp"
#include "query_table.hpp"
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
  QueryOptions queries;
  std::optional<std::filesystem::path> motion;
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

/// Columns behind those of the query; energy and bound only if the model has them.
std::string answer_of(const LoadedModel& model, const Query& query, bool has_energy, bool has_bounds) {
  const auto& [node, d] = query;
  Vec3 f{};
  double energy = 0;
  const rt::Status status = has_energy ? model.data().force(node, d, f, energy) : model.data().force(node, d, f);
  if (!status.ok()) throw failure(status.message(), fmt::format("node {}", node), "give a smaller displacement");
  std::string text = fmt::format(",{},{},{}", f[0], f[1], f[2]);
  if (has_energy) text += fmt::format(",{}", energy);
  text += fmt::format(",{},{}", int{status}, model.trained_depth(node, d));
  if (!has_bounds) return text;
  const auto bound_N = model.error_bound(node, d);
  return text + (bound_N ? fmt::format(",{}", *bound_N) : ",");
}

/// --queries replaces the options of a single query, and its result is a table.
void run_queries(const Options& options) {
  LoadedModel model(options.model);
  if (options.level) model.set_level(*options.level);
  const bool has_energy = model.runtime().info().has_energy != 0, has_bounds = model.has_bounds();
  const auto active = model.runtime().active_nodes();
  QueryAnswers answers;
  answers.command = "eval";
  answers.columns = fmt::format(",fx_N,fy_N,fz_N{},status,trained_depth_m{}", has_energy ? ",energy_J" : "",
                                has_bounds ? ",bound_N" : "");
  answers.check = [&](const Query& query) {
    if (!std::binary_search(active.begin(), active.end(), query.node))
      model.force(query.node, {0, 0, 0});  // throws an error with the nearest active nodes
  };
  answers.answer = [&](const Query& query) { return answer_of(model, query, has_energy, has_bounds); };
  answer_queries(options.queries, answers);
}

/// @param where  the tool, for messages
/// @throws Error (input) unless the surface has a triangle with these nodes
void require_triangle(const Motion::Tool& tool, const std::string& where, const Mesh& mesh) {
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t) {
    const auto corners = mesh.surface.row(t);
    if (std::all_of(tool.nodes.begin(), tool.nodes.end(),
                    [&](auto node) { return node < 0 || (corners.array() == node).any(); }))
      return;
  }
  throw input_error(where + ": the surface has no triangle with these nodes",
                    fmt::format("{}, {}{}", tool.nodes[0], tool.nodes[1],
                                tool.nodes[2] < 0 ? "" : fmt::format(", {}", tool.nodes[2])),
                    "give nodes and weights as eval --point x,y,z --json writes them");
}

/// @throws Error (input) unless the mesh has the nodes of all tools, and those of each one are of one triangle
void require_places(const Motion& motion, const std::string& name, const Mesh& mesh) {
  for (std::size_t t = 0; t < motion.tools.size(); ++t) {
    const auto& tool = motion.tools[t];
    for (const auto node : tool.nodes)
      if (node >= mesh.n_nodes())
        throw input_error(name + ": the mesh has no such node", std::to_string(node),
                          "give the model for which the motion was recorded; its nodes are 0 to " +
                              std::to_string(mesh.n_nodes() - 1));
    if (tool.nodes[1] >= 0) require_triangle(tool, fmt::format("{}: tools[{}]", name, t), mesh);
  }
}

/// --motion replaces the options of a single query, except --json.
void run_motion(const Options& options) {
  const auto& tool = options.tool;
  if (!tool.nodes.empty() || !tool.points.empty() || !tool.displacements.empty())
    throw input_error("--motion excludes tools on the command line",
                      "--motion together with --node, --point or --displacement", "omit either --motion or the tools");
  if (options.queries.file || tool.deformation_csv || options.surface || options.levels > 0 || options.tools == "paper")
    throw input_error("--motion only writes forces",
                      "--motion together with --queries, --deformation, --surface, --subdivide or --tools paper",
                      "use --json for the forces, or these options for one query with --node");
  const auto name = options.motion->string();
  const auto motion = read_motion(*options.motion);
  LoadedModel model(options.model);
  if (options.level) model.set_level(*options.level);
  require_places(motion, name, model.mesh());
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
  options->queries.add_to(*command);
  add_path(*command, "--motion", options->motion, InputKind::whole,
           "JSON file of a recorded motion of tools (formats/motion.md), instead of --node; --json writes its forces");
  command
      ->add_option("--tools", options->tools,
                   "method for several tools: coupled (with forces), or paper (weights (15)-(16), without forces)")
      ->check(CLI::IsMember({"coupled", "paper"}));
  command->add_option("--level", options->level, "level of the model; 0 is the smallest (default: the full one)");
  add_path(*command, "--surface", options->surface, OutputKind::file,
           "write the surface: undeformed with its displacement (.vtu) or deformed (.obj)");
  command->add_option("--subdivide", options->levels, "levels of subdivision of that surface (Loop's scheme)")
      ->check(CLI::Range(0, 6));
  command->callback([options] {
    options->queries.check(options->tool, options->surface || options->levels > 0 ? "--surface or --subdivide" : "");
    if (options->motion) return run_motion(*options);
    options->queries.file ? run_queries(*options) : run(*options);
  });
}

}  // namespace phynness::cli::eval_command
