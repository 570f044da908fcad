// The subcommands that need dolfinx, in a build without it: they say so.
#include <phynness/formats/error.hpp>

#include "commands.hpp"

namespace phynness::cli {
namespace {

void add(CLI::App& app, const std::string& name) {
  auto* command = app.add_subcommand(name, "(not in this build: needs dolfinx)");
  command->allow_extras();
  command->callback([name] {
    throw input_error("this build has no finite element solver", "phynness " + name,
                      "build with -DPHYNNESS_WITH_DOLFINX=ON on a machine that has dolfinx");
  });
}

}  // namespace

void add_precompute_command(CLI::App& app) { add(app, "precompute"); }
void add_validate_command(CLI::App& app) { add(app, "validate"); }
void add_solve_command(CLI::App& app) { add(app, "solve"); }
void add_run_command(CLI::App& app) { add(app, "run"); }

}  // namespace phynness::cli
