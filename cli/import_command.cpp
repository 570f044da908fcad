#include <phynness/formats/imported.hpp>

#include "commands.hpp"

namespace phynness::cli::import_command {
namespace {

struct Options {
  std::filesystem::path file, output;
  OptionalPath json_file;
};

void run(const Options& options) {
  install_stop_handler();
  const auto report = [&] {
    Progress progress("import", "response sets");
    return import_responses(read_responses(options.file), options.output, progress.counter(), stop_requested);
  }();
  for (const auto& note : report.notes) message("note: {}\n", note);
  for (const auto& warning : report.warnings) message("warning: {}\n", warning);
  print_result("{} responses, {} different displacements up to {:.4g} m, forces up to {:.4g} N -> {}, {}\n",
               report.rows, report.displacements, report.largest_displacement_m, report.largest_force_N,
               options.output.string(), bytes(std::filesystem::file_size(options.output)));
  if (report.energy_over_work > 0)
    print_result("energy over force . displacement {:.3f} in the median; of linear responses it is 0.5\n",
                 report.energy_over_work);
  write_json(options.json_file, figures(report));
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "import",
                  "Make a database of the responses of another program, or of measurements (formats/imported.md)", run);
  add_path(command, "FILE", options.file, PathKind::input, "HDF5 file of responses")->required();
  add_output(command, options.output, PathKind::database, "database to write; phynness train takes it without a scene");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::import_command
