#include <phynness/validation/model_figures.hpp>

#include "commands.hpp"

namespace phynness::cli::bench_command {
namespace {

struct Options {
  std::filesystem::path model;
  OptionalPath body;
  OptionalPath json_file;
};

/// An error of 0 was not estimated (phn_level).
json estimated(double error) { return error > 0 ? json(error) : json(nullptr); }
std::string percent(double error) { return error > 0 ? fmt::format("{:.3f}", 100 * error) : "-"; }

/// Measures the time of a step of the body for increasing numbers of tools, at nodes that are spread over the model.
json steps_of(const NamedOrgan& model, const NamedOrgan& body) {
  const auto active = model.active_nodes();
  json steps = json::array();
  print_result("{:<6} {:>13}\n", "tools", "body step us");
  for (std::size_t n = 1; n <= std::min<std::size_t>(PHN_MOST_COUPLED, active.size()); n *= 2) {
    std::vector<std::int32_t> nodes;
    for (std::size_t t = 0; t < n; ++t) nodes.push_back(active[t * active.size() / n]);
    const double us = measure_step_us(body, nodes);
    print_result("{:<6} {:>13.0f}\n", n, us);
    steps.push_back(record("tools", n, "step_us", us));
  }
  return steps;
}

void run(const Options& options) {
  NamedOrgan model(options.model);
  std::optional<NamedOrgan> body;
  if (options.body) body = model.body_on_same_mesh(*options.body);
  const std::int32_t n = model.info().n_levels;
  json levels = json::array();
  print_result("{:<6} {:>13} {:>19} {:>6} {:>10} {:>14} {:>9} {:>15}\n", "level", "force centers",
               "deformation centers", "modes", "force us", "deformation us", "force %", "displacement %");
  for (std::int32_t l = 0; l < n; ++l) {
    phn_level info;
    phn_level_info(model.organ().model(), l, &info);
    model.set_level(l);
    const auto time = measure_speed(model);
    print_result("{:<6} {:>13} {:>19} {:>6} {:>10.3f} {:>14.3f} {:>9} {:>15}\n", l, info.force_centers,
                 info.deformation_centers, info.modes, time.force_us, time.deformation_us, percent(info.error_force),
                 percent(info.error_displacement));
    levels.push_back(record("force_centers", info.force_centers, "deformation_centers", info.deformation_centers,
                            "modes", info.modes, "error_force", estimated(info.error_force), "error_displacement",
                            estimated(info.error_displacement), "force_us", time.force_us, "deformation_us",
                            time.deformation_us));
  }
  if (n > 1)
    print_result(
        "errors: leave-one-out errors of the median node, relative to the largest force or displacement of the "
        "node\n");
  else
    print_result(
        "errors: not estimated for a model of one level; [training] levels trains more and estimates errors\n");
  json figures = record("levels", levels);
  if (body) figures["body"] = steps_of(model, *body);
  write_json(options.json_file, figures);
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(
      app, "bench", "Measure the time of a force and a deformation of a model, and of a step of a body", run);
  add_model(command, options.model);
  add_path(command, "--body", options.body, PathKind::input,
           "body.txt of the same mesh: also the time of a step with 1 to 8 tools");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::bench_command
