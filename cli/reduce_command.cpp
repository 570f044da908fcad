#include "reduce_command.hpp"

#include <phynness/formats/text_file.hpp>
#include <phynness/schema/body_grammar.hpp>

namespace phynness::cli::reduce_command {
namespace {

constexpr double usual_target = 0.1;

struct Options {
  std::filesystem::path database, output;
  std::optional<int> modes, cells;
  std::optional<std::string> target_error;
  OptionalPath scene, json_file;
};

void run(const Options& options) {
  const auto target = limit_of(options.target_error, "--target-error", {{"%", 0.01}, {"", 1}}, "10%");
  const auto scene = options.scene ? std::optional(open_scene(*options.scene)) : std::nullopt;
  ReductionSpec spec;
  spec.modes = options.modes.value_or(spec.modes);
  spec.cells = options.cells.value_or(spec.cells);
  // Nothing is written before all long work is done, so that a signal may end it at any time.
  end_at_signals("the reduction was interrupted\n  remedy: run the same command again; nothing was written\n");
  auto made = reduced(options.database, spec,
                      options.modes || options.cells ? std::nullopt : std::optional(target.value_or(usual_target)),
                      scene ? scene->probe.tools : 0);
  if (!made) return;
  if (scene) made->body.relaxation = carried_relaxation(*scene);
  const auto& [body, report, sizes] = *made;
  const auto text = write_body_text(body);
  install_stop_handler();  // the file is written, or not at all
  json out = figures(report);
  out["sizes"] = sizes;
  out["body_bytes"] = text.size();
  write_each({[&] { write_text_file(options.output, text); }, [&] { write_json(options.json_file, out); }});
  print_result(
      "{} fields, and {} of several tools, in {}: {} modes have {:.4g} % of the first, and there are {} of the "
      "pressure\n",
      report.fields, report.several_fields, duration(report.seconds), report.modes, 100 * report.captured,
      report.pressures);
  print_result("{} of {} points, cells and edges, have weights", report.cells, report.points);
  if (report.states > 0)
    print_result("; forces and volumes of {} states are off by {:.3g} %", report.states, 100 * report.residual);
  print_result("\n{} -> {}\n", bytes(text.size()), options.output.string());
  // Bodies of a tenth had errors of 2 to 4 % (docs/decisions/reduced-body.md), those of nine tenths of 100 %.
  if (report.residual > 0.2)
    message("warning: the forces of the cells are off by {:.3g} %; give more --cells\n", 100 * report.residual);
  if (report.modes < schema::least_body_modes(2))
    message("warning: a body of {} modes answers one tool, two need {}; give more --modes\n", report.modes,
            schema::least_body_modes(2));
  if (report.captured < 0.99)
    message("warning: the modes leave out {:.3g} % of the fields; give more --modes\n", 100 - 100 * report.captured);
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "reduce", "Reduce the finite elements of a database to modes and a few cells -> BODY.txt", run);
  add_database(command, options.database, "database.h5 of phynness precompute, with output = \"free\"");
  add_output(command, options.output, PathKind::file, "file to write (formats/body.md)");
  add_path(command, "--scene", options.scene, PathKind::input,
           "scene whose [material] relaxation the body has (default: the scene in the database)");
  const ReductionSpec usual;
  auto* target =
      command.add_option("--target-error", options.target_error,
                         fmt::format("make larger bodies until the force error of two tools is at most this in 95 % of "
                                     "random states, and three times this in all (default: {:.3g} %)",
                                     100 * usual_target));
  add_count(command, "--modes", options.modes, schema::least_body_modes(1), schema::most_body_modes,
            fmt::format("make one body with this number of displacement modes (default: {} at first)", usual.modes))
      ->excludes(target);
  add_count(command, "--cells", options.cells, 1, 1'000'000,
            fmt::format("make one body with this number of weighted cells and edges, or with all if there are fewer "
                        "(default: {} at first, {} with regions)",
                        usual_cells(false), usual_cells(true)))
      ->excludes(target);
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::reduce_command
