#include <phynness/evaluation/model_figures.hpp>

#include "commands.hpp"

namespace phynness::cli::bench_command {
namespace {

struct Options {
  std::filesystem::path model;
  std::optional<double> budget_us;
  double forces = 1, deformations = 1;
  OptionalPath json_file;
};

/// An error of 0 means that it was not estimated (phn_level).
json estimated(double error) { return error > 0 ? json(error) : json(nullptr); }
std::string percent(double error) { return error > 0 ? fmt::format("{:.3f}", 100 * error) : "-"; }

void run(const Options& options) {
  const LoadedModel model(options.model);
  const auto times = measure_levels(model);
  json levels = json::array();
  print_result("{:<6} {:>13} {:>19} {:>6} {:>10} {:>14} {:>9} {:>15}\n", "level", "force centers",
               "deformation centers", "modes", "force us", "deformation us", "force %", "displacement %");
  for (std::int32_t l = 0; l < model.runtime().n_levels(); ++l) {
    phn_level info;
    model.runtime().level_info(l, info).ignore();
    const auto& time = times[static_cast<std::size_t>(l)];
    print_result("{:<6} {:>13} {:>19} {:>6} {:>10.3f} {:>14.3f} {:>9} {:>15}\n", l, info.force_centers,
                 info.deformation_centers, info.modes, time.force_us, time.deformation_us, percent(info.error_force),
                 percent(info.error_displacement));
    levels.push_back(record("force_centers", info.force_centers, "deformation_centers", info.deformation_centers,
                            "modes", info.modes, "error_force", estimated(info.error_force), "error_displacement",
                            estimated(info.error_displacement), "force_us", time.force_us, "deformation_us",
                            time.deformation_us));
  }
  if (times.size() > 1)
    print_result(
        "errors: leave-one-out errors of the median node, relative to the largest force or displacement of the "
        "node\n");
  else
    print_result(
        "errors: not estimated for a model of one level; [training] levels trains more and estimates errors\n");
  json out = record("levels", levels);
  rt::Status status;
  if (options.budget_us) {
    std::int32_t level = 0;
    status = model.runtime().budget(times, options.forces, options.deformations, *options.budget_us, level);
    out["budget_us"] = *options.budget_us;
    out["level"] = nullptr;
    if (status == PHN_OK) {
      out["level"] = level;
      print_result("{:g} forces and {:g} deformations in {:g} us: level {}\n", options.forces, options.deformations,
                   *options.budget_us, level);
    }
  }
  write_each({[&] { write_json(options.json_file, out); },
              [&] {
                if (status != PHN_OK)
                  throw failure(status.message(), fmt::format("{:g} us", *options.budget_us),
                                "increase --budget, train more levels, or train a smaller model");
              }});
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "bench", "Measure the time of a force and a deformation at each level of a model", run);
  add_model(command, options.model);
  add_number(command, "--budget", options.budget_us, 0, 1e12, "print the level that fits into this time [us]");
  add_number(command, "--forces", options.forces, 0, 1e12, "number of forces within the budget");
  add_number(command, "--deformations", options.deformations, 0, 1e12, "number of deformations within the budget");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::bench_command
