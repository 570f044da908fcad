#include <phynness/formats/text_file.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/training/reduction.hpp>

#include "commands.hpp"

namespace phynness::cli::reduce_command {
namespace {

struct Options {
  std::filesystem::path database, output;
  ReductionSpec spec;
  OptionalPath json_file;
};

void run(const Options& options) {
  const auto database = Database::open(options.database);
  // Nothing is written before all long work is done, so that a signal may end it at any time.
  end_at_signals("the reduction was interrupted\n  remedy: run the same command again; nothing was written\n");
  ReductionReport report;
  std::string text;
  {
    Progress progress("reduce", "steps");
    text = write_body_text(reduce(database, options.spec, report, progress.counter()));
  }
  install_stop_handler();  // the file is written, or not at all
  json out = figures(report);
  out["body_bytes"] = text.size();
  write_each({[&] { write_text_file(options.output, text); }, [&] { write_json(options.json_file, out); }});
  print_result(
      "{} fields, and {} of pairs, in {}: {} modes have {:.4g} % of the first, and there are {} of the pressure\n",
      report.fields, report.pair_fields, duration(report.seconds), report.modes, 100 * report.captured,
      report.pressures);
  print_result("{} of {} points, cells and edges, have weights", report.cells, report.points);
  if (report.states > 0)
    print_result("; forces and volumes of {} states are off by {:.3g} %", report.states, 100 * report.residual);
  print_result("\n{} -> {}\n", bytes(text.size()), options.output.string());
  // Bodies of a tenth had errors of 2 to 4 % (docs/decisions/reduced-body.md), those of nine tenths of 100 %.
  if (report.residual > 0.2)
    message("warning: the forces of the cells are off by {:.3g} %; give more --cells\n", 100 * report.residual);
  if (report.captured < 0.99)
    message("warning: the modes leave out {:.3g} % of the fields; give more --modes\n", 100 - 100 * report.captured);
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "reduce", "Reduce the finite elements of a database to modes and a few cells -> BODY.txt", run);
  add_database(command, options.database, "database.h5 of phynness precompute, with output = \"free\"");
  add_output(command, options.output, PathKind::file, "file to write (formats/body.md)");
  add_count(command, "--modes", options.spec.modes, 1, schema::most_body_modes, "modes of the displacement")
      ->capture_default_str();
  add_count(command, "--cells", options.spec.cells, 1, 1'000'000,
            "cells and edges with weights; all of them, with weight 1, if there are not more")
      ->capture_default_str();
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::reduce_command
