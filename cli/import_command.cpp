#include <phynness/formats/imported.hpp>
#include <phynness/meshes/tool_weights.hpp>

#include "commands.hpp"

namespace phynness::cli::import_command {
namespace {

struct Options {
  std::filesystem::path file, output;
  OptionalPath json_file;
};

void run(const Options& options) {
  const auto report = import_responses(options.file, options.output, tools_of);
  print_result("{} rays up to {:.4g} m, {} left out, forces up to {:.4g} N -> {}, {}\n", report.rays,
               report.largest_displacement_m, report.missing_rays, report.largest_force_N, options.output.string(),
               bytes(std::filesystem::file_size(options.output)));
  if (report.energy_over_work > 0)
    print_result("energy over force . displacement {:.3f} in the median; of linear responses it is 0.5\n",
                 report.energy_over_work);
  if (!report.against.empty())
    message("warning: forces of {} of {} rays point against the displacement, first {}: check their signs\n",
            report.against.size(), report.rays, report.against.front());
  write_json(options.json_file, figures(report));
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "import", "Make a database of the responses of another program (formats/imported.md)", run);
  add_path(command, "FILE", options.file, PathKind::input, "HDF5 file of responses")->required();
  add_output(command, options.output, PathKind::database, "database to write; phynness train takes it without a scene");
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::import_command
