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
                                     "Predict time, memory and sizes of precompute, and the useful number of ranks, "
                                     "from a sample of solved rays");
  add_path(*command, "SCENE", options->source, InputKind::whole,
           "scene file; or a finished database.h5, whose measured costs replace the sample")
      ->required();
  command
      ->add_option("--ranks", options->ranks,
                   "number of MPI processes of the plan (default: the processor cores of this machine)")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--rays", options->rays, "number of rays to solve")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of the random choice of rays")
      ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()))
      ->capture_default_str();
  command->add_flag("--table", options->table, "print times and limiting factors for 1 to 10,000 ranks");
  add_path(*command, "--json", options->json_file, OutputKind::file, "write the plan as JSON");
  const auto assumed = [&](const char* name, double& value, const char* what) {
    command->add_option(name, value, what)
        ->check(finite_range(0, 1e9))
        ->capture_default_str()
        ->group("Assumptions about the machine");
  };
  assumed("--launch-s", options->launch_s, "time from the start of the job until all ranks run [s]");
  command
      ->add_option("--bandwidth-MB-per-s", options->bandwidth_MB_per_s,
                   "bandwidth of the file system for all ranks together [MB/s]")
      ->check(finite_range(1e-3, 1e9))
      ->capture_default_str()
      ->group("Assumptions about the machine");
  assumed("--open-ms", options->open_ms, "time to make or open a file, one after the other [ms]");
  assumed("--fetch-us", options->fetch_us, "time to fetch the next task, half of it latency [us]");
  command
      ->add_option("--start-s", options->start_s,
                   "time to read scene and mesh [s] (default: measured for a scene, 0 for a database)")
      ->check(finite_range(0, 1e9))
      ->group("Assumptions about the machine");
  command
      ->add_option("--setup-ms", options->setup_ms,
                   "time to prepare the next node [ms] (default: measured for a scene, 0 for a database)")
      ->check(finite_range(0, 1e9))
      ->group("Assumptions about the machine");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::plan_command
