// The subcommands that need dolfinx, for a build without it. They only report that they are missing.
#include <phynness/formats/error.hpp>

#include "plan.hpp"

namespace phynness::cli {
namespace {

Error no_solver(const std::string& what) {
  return input_error("this build has no finite element solver", what,
                     "build with -DPHYNNESS_WITH_DOLFINX=ON on a machine that has dolfinx");
}

void add_refusal(CLI::App& app, const std::string& name) {
  auto* command = app.add_subcommand(name, "(not in this build, because it needs dolfinx)");
  command->allow_extras();
  command->callback([name] { throw no_solver("phynness " + name); });
}

}  // namespace

void precompute_command::add(CLI::App& app) { add_refusal(app, "precompute"); }
void calibrate_command::add(CLI::App& app) { add_refusal(app, "calibrate"); }
void validate_command::add(CLI::App& app) { add_refusal(app, "validate"); }
void tune_command::add(CLI::App& app) { add_refusal(app, "tune"); }
void check_command::add(CLI::App& app) { add_refusal(app, "check"); }
void solve_command::add(CLI::App& app) { add_refusal(app, "solve"); }
void run_command::add(CLI::App& app) { add_refusal(app, "run"); }

PlanBasis basis_of_scene(const PlanOptions& options) {
  throw no_solver("phynness plan " + options.source.string() + " (a plan from a finished database.h5 is possible)");
}

}  // namespace phynness::cli
