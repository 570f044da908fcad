#include <limits>

#include "command_files.hpp"
#include "console.hpp"
#include "plan.hpp"

namespace phynness::cli::plan_command {
namespace {

bool is_database(const std::filesystem::path& file) { return file.extension() == ".h5" || file.extension() == ".hdf5"; }

void run(const PlanOptions& options) {
  const auto basis = is_database(options.source) ? basis_of_database(options) : basis_of_scene(options);
  write_json(options.json_file, report_plan(options, basis));
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<PlanOptions>();
  auto* command = app.add_subcommand("plan",
                                     "Predict time, memory and sizes of a precompute from a few dozen solved "
                                     "rays, and how many ranks are of use");
  add_path(*command, "SCENE", options->source, InputKind::whole,
           "scene file; or a finished database.h5, whose measured costs are then taken instead of a sample")
      ->required();
  command
      ->add_option("--ranks", options->ranks, "MPI processes to plan for; default: the processor cores of this machine")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--rays", options->rays, "rays to solve")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--seed", options->seed, "which rays")
      ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()))
      ->capture_default_str();
  command->add_flag("--table", options->table, "print times on 1 to 10,000 ranks, and what limits each");
  add_path(*command, "--json", options->json_file, OutputKind::file, "write the plan for machines");
  const auto assumed = [&](const char* name, double& value, const char* what) {
    command->add_option(name, value, what)
        ->check(finite_range(0, 1e9))
        ->capture_default_str()
        ->group("Assumed of the machine");
  };
  assumed("--launch-s", options->launch_s, "s from the start of the job until all ranks run");
  command->add_option("--bandwidth-MB-per-s", options->bandwidth_MB_per_s, "of the file system, for all ranks together")
      ->check(finite_range(1e-3, 1e9))
      ->capture_default_str()
      ->group("Assumed of the machine");
  assumed("--open-ms", options->open_ms, "ms to make or open a file, one after the other");
  assumed("--fetch-us", options->fetch_us, "us to ask for the next task, half of it on the way");
  command->add_option("--start-s", options->start_s, "s to read scene and mesh (a scene: measured; a database: 0)")
      ->check(finite_range(0, 1e9))
      ->group("Assumed of the machine");
  command->add_option("--setup-ms", options->setup_ms, "ms to turn to another node (a scene: measured; a database: 0)")
      ->check(finite_range(0, 1e9))
      ->group("Assumed of the machine");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::plan_command
