#include <algorithm>
#include <cmath>
#include <phynness/formats/body.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/vtk.hpp>
#include <phynness/validation/named_organ.hpp>
#include <utility>

#include "commands.hpp"
#include "query_table.hpp"

namespace phynness::cli::eval_command {
namespace {

struct Options {
  std::filesystem::path model;
  std::string tools = "coupled";
  ToolOptions tool;
  OptionalPath surface;
  std::optional<std::int32_t> level;
  QueryOptions queries;
  OptionalPath body;
};

/// Largest number of Newton steps of a body in each increment from rest.
constexpr std::int32_t body_steps = 60;

NamedOrgan loaded(const Options& options) {
  NamedOrgan model(options.model);
  if (options.level) model.set_level(*options.level);
  return model;
}
std::optional<NamedOrgan> loaded_body(const Options& options, const NamedOrgan& model) {
  if (!options.body) return std::nullopt;
  return model.body_on_same_mesh(*options.body, body_steps);
}

/// The displacements of a body at the given nodes; zero at nodes that the body does not contain.
Points on_output(const phn_body_contents& info, const Points& displacement_m, const std::vector<std::int32_t>& nodes) {
  Points out = Points::Zero(std::ssize(nodes), 3);
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const auto node = nodes[static_cast<std::size_t>(i)];
    const auto* at = std::lower_bound(info.nodes, info.nodes + info.n_nodes, node);
    if (at != info.nodes + info.n_nodes && *at == node) out.row(i) = displacement_m.row(at - info.nodes);
  }
  return out;
}

/// A VTK file of the undeformed surface with the fields `displacement` [m] and `node`.
/// @param displacement_m  n_output x 3
/// @throws Error (input) if the model has no surface
void write_surface(const NamedOrgan& model, const Points& displacement_m, const std::filesystem::path& file) {
  const auto& info = model.info();
  if (info.n_triangles == 0)
    throw input_error(
        "the model has no surface", file.string(),
        "its triangles connect output and fixed nodes: select the surface as nodes.output and train again");
  VtkGrid grid;
  grid.node_numbers.assign(info.output_nodes, info.output_nodes + info.n_output);
  grid.node_numbers.insert(grid.node_numbers.end(), info.fixed_nodes, info.fixed_nodes + info.n_fixed);
  grid.points = model.mesh().nodes(grid.node_numbers, Eigen::all);
  grid.cells = Eigen::Map<const Triangles>(info.triangles, info.n_triangles, 3);
  Eigen::MatrixXd displacement = Eigen::MatrixXd::Zero(grid.points.rows(), 3);
  displacement.topRows(displacement_m.rows()) = displacement_m;
  write_text_file(file, vtu_text(grid, {0, {{"displacement", displacement}}}));
}

std::vector<phn_tool> tools_at(const std::vector<SurfacePoint>& places, const std::vector<Vec3>& displacements) {
  std::vector<phn_tool> tools;
  for (std::size_t t = 0; t < places.size(); ++t) tools.push_back(tool_at(places[t], displacements[t]));
  return tools;
}

/// The warning of a status above 0, with the displacements that exceed the trained depth, or with the cause.
std::string warning_of(const NamedOrgan& model, const std::optional<NamedOrgan>& body, int status,
                       const std::vector<SurfacePoint>& places, const std::vector<Vec3>& displacements) {
  std::string exceeded;
  const auto active = model.active_nodes();
  for (std::size_t t = 0; t < places.size() && (status & PHN_WARNING_OUTSIDE) != 0; ++t) {
    const Vec3& d = displacements[t];
    const double length_m = std::hypot(d[0], d[1], d[2]);
    if (body && length_m > body->body_info().max_displacement_m)
      exceeded +=
          fmt::format("\n  {:.4g} m, the body was trained to {:.4g} m", length_m, body->body_info().max_displacement_m);
    for (std::size_t k = 0; k < 3 && !body; ++k) {
      const auto node = places[t].nodes[k];
      if (places[t].weights[k] == 0 || std::find(active.begin(), active.end(), node) == active.end()) continue;
      const double trained_m = model.trained_depth(node, d);
      if (length_m > trained_m)
        exceeded += trained_m > 0 ? fmt::format("\n  {:.4g} m at node {}, trained to {:.4g} m in its direction",
                                                length_m, node, trained_m)
                                  : fmt::format("\n  at node {} its direction was not trained", node);
    }
  }
  if (status != PHN_WARNING_OUTSIDE || !exceeded.empty()) return phn_status_message(status) + exceeded;
  return body                ? "near a tool there is no probed point"
         : places.size() > 1 ? "the tools work against each other, or one is between nodes beside fixed ones"
                             : "the tool is at or beside nodes where the model is linear or that are fixed";
}

/// The columns of a step of a motion, dt_s after the previous step.
std::string motion_row(const NamedOrgan& organ, const Query& query, double dt_s) {
  const std::vector<phn_tool> tools{tool_at(query.node, query.displacement_m)};
  const auto response = organ.hold(tools);
  Vec3 force = response.force_N[0].value();
  const Organ::Status status = organ.organ().relax(tools, dt_s, force);
  if (!status.ok()) throw failure(status.message(), fmt::format("{:g} s", *query.time_s), "give later times");
  return fmt::format(",{},{},{},{}", force[0], force[1], force[2], response.status | int{status});
}

/// The columns after those of the query; energy and bound only if the model has them.
std::string query_row(const NamedOrgan& model, std::optional<NamedOrgan>& body, const Query& query, bool has_energy,
                      bool has_bounds) {
  const auto& [node, d, time_s] = query;
  if (body) {
    const auto response = body->hold_from_rest({tool_at(node, d)}, increments_from_rest);
    const Vec3& f = *response.force_N[0];
    auto text = fmt::format(",{},{},{},{},{}", f[0], f[1], f[2], *response.energy_J, response.status);
    if (has_bounds) text += response.bound_N[0] ? fmt::format(",{}", *response.bound_N[0]) : ",";
    return text;
  }
  Vec3 f{};
  double energy = 0;
  const phn_tool tool = tool_at(node, d);
  const Organ::Status status = has_energy ? model.organ().hold(tool, f, energy) : model.organ().hold(tool, f);
  if (!status.ok()) throw failure(status.message(), fmt::format("node {}", node), "give a smaller displacement");
  std::string text = fmt::format(",{},{},{}", f[0], f[1], f[2]);
  if (has_energy) text += fmt::format(",{}", energy);
  text += fmt::format(",{},{}", int{status}, model.trained_depth(node, d));
  if (!has_bounds) return text;
  const auto bound_N = model.error_bound(node, d);
  return text + (bound_N ? fmt::format(",{}", *bound_N) : ",");
}

/// Answers the table of --queries.
void run_queries(const Options& options) {
  const NamedOrgan model = loaded(options);
  auto body = loaded_body(options, model);
  const bool has_energy = body || model.info().has_energy != 0,
             has_bounds = body ? body->has_bounds() : model.has_bounds();
  const auto active = model.active_nodes();
  QueryAnswers answers;
  answers.command = "eval";
  answers.columns = fmt::format(",fx_N,fy_N,fz_N{},status{}{}", has_energy ? ",energy_J" : "",
                                body ? "" : ",trained_depth_m", has_bounds ? ",bound_N" : "");
  answers.check = [&](const Query& query) {
    if (body)
      body->hold({tool_at(query.node, {0, 0, 0})});  // throws an error if nothing there can move
    else if (!std::binary_search(active.begin(), active.end(), query.node))
      model.force(query.node, {0, 0, 0});  // throws an error with the nearest active nodes
  };
  answers.motion_columns = ",fx_N,fy_N,fz_N,status";
  double last_s = 0;
  answers.answer = [&](const Query& query) -> std::string {
    if (query.time_s)
      return motion_row(body ? *body : model, query, *query.time_s - std::exchange(last_s, *query.time_s));
    return query_row(model, body, query, has_energy, has_bounds);
  };
  answer_queries(options.queries, answers);
}

void print_bound(const NamedOrgan& model, const std::optional<NamedOrgan>& body, std::size_t n_tools, int status,
                 const std::optional<double>& bound_N) {
  if (bound_N)
    print_result(
        "error of the force{}: at most {:.3g} N for {:g} % of random displacements\n",
        body ? " from the elements of the body" : model.model().bounds.at(0).from(), *bound_N,
        100 * (body ? read_body_text(body->text(), body->name()).coverage : model.model().bounds.at(0).coverage));
  else if ((status & PHN_WARNING_OUTSIDE) != 0)
    print_result("error of the force: unknown outside of the trained range\n");
  else if (!body && n_tools > 1)
    print_result("error of the force: unknown, because bounds of a model are those of one tool\n");
  else if (body ? !body->has_bounds() : model.model().bounds.empty())
    print_result("error of the force: unknown, because the {} has no bounds{}\n", body ? "body" : "model",
                 body                               ? "; phynness calibrate --body adds them"
                 : can_be_calibrated(model.model()) ? "; phynness calibrate adds them"
                                                    : "");
  else
    print_result(
        "error of the force: unknown, because bounds were not calibrated for such a place, level or number of tools\n");
}

void run_single(const Options& options) {
  if (options.surface && options.surface->extension() != ".vtu")
    throw input_error("the format of the surface file is unknown", options.surface->string(),
                      "give --surface a name that ends in .vtu");
  const auto displacements = options.tool.parsed_displacements();
  if (options.tools == "paper" && !options.tool.points.empty())
    throw input_error("--tools paper is only defined for tools at nodes", "--point " + options.tool.points.front(),
                      "use --tools coupled, or use --node");
  const NamedOrgan model = loaded(options);
  auto body = loaded_body(options, model);
  const auto places = options.tool.places(model.mesh());
  const auto active = model.active_nodes();
  const bool all_active = std::ranges::all_of(
      options.tool.nodes, [&](std::int32_t node) { return std::ranges::binary_search(active, node); });
  const bool coupled =
      options.tools == "coupled" && (places.size() > 1 || !options.tool.points.empty() || body || !all_active);
  const auto tools = tools_at(places, displacements);
  const auto response = body      ? body->hold_from_rest(tools, increments_from_rest)
                        : coupled ? model.hold(tools)
                                  : model.blend(options.tool.nodes, displacements);
  const auto& output_file = options.tool.deformation_csv ? options.tool.deformation_csv : options.surface;
  if (response.displacement_m.rows() == 0 && output_file)
    throw input_error("this model has forces only", output_file->string(),
                      "omit the output file, or train the model with [training] modes of 1 or more");
  if (response.status > 0) message("warning: {}\n", warning_of(model, body, response.status, places, displacements));
  json extra = record("status", response.status, "family", model.info().family, "level", model.level());
  const bool bounded = !coupled && places.size() == 1 && model.has_bounds();
  std::optional<double> bound_N;
  if (bounded) bound_N = model.error_bound(options.tool.nodes.front(), displacements.front());
  if (options.body) extra["body"] = options.body->string();
  if (bounded) extra["bound_N"] = bound_N ? json(*bound_N) : json(nullptr);
  const auto& bounds = response.bound_N;
  if (coupled) extra["residual"] = response.report.residual_m;
  for (const auto& bound : bounds) extra["bounds_N"].push_back(bound ? json(*bound) : json(nullptr));
  const auto& info = model.info();
  const auto all = model.output_nodes();
  const std::vector<std::int32_t> output(all.begin(), all.end());
  ToolResult result{response.force_N, response.energy_J, response.displacement_m, output, {}};
  if (body) result.nodes.assign(body->body_info().nodes, body->body_info().nodes + body->body_info().n_nodes);
  for (Eigen::Index f = 0; f < response.fields.cols(); ++f) {
    const std::string field = info.field_names[f];
    const auto known = field_named(field);
    result.fields.push_back({field, info.field_units[f], known ? column(*known) : field, response.fields.col(f)});
  }
  report_tools(options.tool, places, displacements, model.mesh(), result, extra, [&] {
    if (!options.surface) return;
    const auto& u = response.displacement_m;
    write_surface(model, body ? on_output(body->body_info(), u, output) : u, *options.surface);
    message("surface of {} triangles: {}\n", info.n_triangles, options.surface->string());
  });
  const bool is_exact = !body && schema::traits(model.model().family).proportional;
  if (bounds.empty() && !is_exact && (coupled || places.size() == 1))
    print_bound(model, body, places.size(), response.status, bound_N);
  for (const auto& bound : bounds) print_bound(model, body, places.size(), response.status, bound);
}

void run(const Options& options) {
  if (options.body && (options.tools == "paper" || options.level))
    throw input_error("a body has neither the paper's method nor levels", "--body " + options.body->string(),
                      "omit --tools paper and --level, or --body");
  if (options.queries.file)
    run_queries(options);
  else
    run_single(options);
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "eval", "Compute force and deformation from a model with the runtime", run);
  add_model(command, options.model);
  options.tool.add_to(command);
  command
      .add_option("--tools", options.tools,
                  "method for several tools: coupled (with forces), or paper (weights (15)-(16), without forces)")
      ->check(CLI::IsMember({"coupled", "paper"}));
  command.add_option("--level", options.level, "level of the model; 0 is the smallest (default: the full one)");
  add_path(command, "--surface", options.surface, PathKind::file,
           "write the undeformed surface with its displacement, .vtu for ParaView");
  add_path(command, "--body", options.body, PathKind::input,
           "a reduced body (body.txt) of the model's mesh, which answers every tool");
  options.queries.add_to(command,
                         {"--node", "--point", "--displacement", "--deformation", "--surface", "--tools", "--json"});
}

}  // namespace phynness::cli::eval_command
