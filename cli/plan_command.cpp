#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>
#include <phynness/formats/ray_tasks.hpp>

#include "command_files.hpp"
#include "console.hpp"
#include "plan.hpp"

namespace phynness::cli {
namespace {

bool is_database(const std::filesystem::path& file) { return file.extension() == ".h5" || file.extension() == ".hdf5"; }

void run(const PlanOptions& options) {
  install_stop_handler();
  const auto basis = is_database(options.source) ? basis_of_database(options) : basis_of_scene(options);
  write_json(options.json_file, report_plan(options, basis));
}

}  // namespace

PlanBasis basis_of_database(const PlanOptions& options) {
  const auto database = Database::open(options.source);
  const auto& header = database.header();
  const MirroredRays mirrored(header);
  PlanBasis basis;
  basis.increments = static_cast<int>(header.magnitudes_m.size());
  basis.work.rays = rays_left(header, std::vector<char>(header.sets.active.size() * header.directions.size(), 0));
  std::vector<Ray> tried;  // rays of nodes spread over the file, for the packing trial
  const std::size_t n_active = header.sets.active.size();
  std::size_t n_solving = 0;  // nodes whose rays are not all mirror images
  for (std::size_t a = 0; a < n_active; ++a) n_solving += mirrored.solves_any(static_cast<std::int32_t>(a));
  const std::size_t n_tried = std::min<std::size_t>(n_solving, 12),
                    per_node = std::max<std::size_t>(1, static_cast<std::size_t>(options.rays) / n_tried);
  std::size_t solving = 0;
  Progress progress("read", "nodes");
  for (std::size_t a = 0; a < n_active; ++a) {
    if (stop_requested()) throw failure("interrupted", "no plan was made", "run the command again");
    const auto rays = database.rays(static_cast<std::int32_t>(a));
    const std::size_t before = solving;
    solving += mirrored.solves_any(static_cast<std::int32_t>(a));
    const bool in_trial = before * n_tried / n_solving != solving * n_tried / n_solving;
    std::size_t taken = 0;
    for (const auto& ray : rays) {
      if (!mirrored.is_solved(ray.active, ray.direction)) {
        ++basis.rays_mirrored;
        continue;
      }
      basis.work.seconds.push_back(std::accumulate(ray.seconds.begin(), ray.seconds.end(), 0.0));
      const bool requested = ray.status.front() != Status::not_requested;
      basis.rays_requested += requested;
      if (requested)
        for (const auto status : ray.status) ++basis.states[status];
      if (in_trial && requested && taken++ < per_node) tried.push_back(ray);
    }
    progress.update(static_cast<std::int64_t>(a + 1), static_cast<std::int64_t>(n_active));
  }
  if (tried.empty())
    throw input_error("no ray of the database was solved", options.source.string(), "plan from its scene file");
  basis.rays_measured = basis.rays_requested;
  basis.nodes_measured = static_cast<std::int64_t>(n_solving);
  basis.packing = try_packing(header, tried, std::filesystem::temp_directory_path());
  basis.work.bytes_per_ray = basis.packing.record_bytes;
  basis.model = predict_model_size(stored_scene(header), header);
  return basis;
}

void add_plan_command(CLI::App& app) {
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
  command->add_option("--seed", options->seed, "seed of the random choice of rays")->capture_default_str();
  command->add_flag("--table", options->table, "print times and limiting factors for 1 to 10,000 ranks");
  add_path(*command, "--json", options->json_file, OutputKind::file, "write the plan as JSON");
  const auto assumed = [&](const char* name, double& value, const char* what) {
    command->add_option(name, value, what)
        ->check(CLI::Range(0.0, 1e9))
        ->capture_default_str()
        ->group("Assumptions about the machine");
  };
  assumed("--launch-s", options->launch_s, "time from the start of the job until all ranks run [s]");
  command
      ->add_option("--bandwidth-MB-per-s", options->bandwidth_MB_per_s,
                   "bandwidth of the file system for all ranks together [MB/s]")
      ->check(CLI::Range(1e-3, 1e9))
      ->capture_default_str()
      ->group("Assumptions about the machine");
  assumed("--open-ms", options->open_ms, "time to make or open a file, one after the other [ms]");
  assumed("--fetch-us", options->fetch_us, "time to fetch the next task, half of it latency [us]");
  command
      ->add_option("--start-s", options->start_s,
                   "time to read scene and mesh [s] (default: measured for a scene, 0 for a database)")
      ->check(CLI::Range(0.0, 1e9))
      ->group("Assumptions about the machine");
  command
      ->add_option("--setup-ms", options->setup_ms,
                   "time to prepare the next node [ms] (default: measured for a scene, 0 for a database)")
      ->check(CLI::Range(0.0, 1e9))
      ->group("Assumptions about the machine");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli
