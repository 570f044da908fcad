#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <ctime>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/ray_tasks.hpp>
#include <phynness/planning/ray_sample.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>

#include "console.hpp"
#include "plan.hpp"

namespace phynness::cli {
namespace {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

std::vector<RayChoice> choose(const DatabaseHeader& header, const std::vector<char>& requested,
                              const PlanOptions& options) {
  const auto points = [&](const std::vector<std::int32_t>& nodes) {
    Points x(static_cast<Eigen::Index>(nodes.size()), 3);
    for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = header.mesh.nodes.row(nodes[static_cast<std::size_t>(i)]);
    return x;
  };
  return choose_rays(points(header.sets.active), points(header.sets.fixed), requested, header.directions.size(),
                     static_cast<std::size_t>(options.rays), static_cast<std::uint64_t>(options.seed));
}

double seconds_of(const Ray& ray) { return std::accumulate(ray.seconds.begin(), ray.seconds.end(), 0.0); }

/// Solves the sample. The first ray is solved twice, so that costs that occur once per process count as start time.
SolvedRays solve(ProbeSolver& solver, const DatabaseHeader& header, const std::vector<RayChoice>& chosen,
                 PlanBasis& basis) {
  std::vector<std::pair<std::int32_t, std::int32_t>> which;
  for (const auto& ray : chosen) which.emplace_back(ray.active, ray.direction);
  const auto total = static_cast<std::int64_t>(which.size()) + 1;
  Progress progress("plan", "rays");
  const auto cold = solve_rays(solver, header, {which.front()}, {}, stop_requested);
  progress.update(1, total);
  auto solved = solve_rays(
      solver, header, which, [&](std::int64_t done) { progress.update(done + 1, total); }, stop_requested);
  if (solved.interrupted || cold.interrupted)
    throw failure("interrupted", fmt::format("{} of {} rays solved", solved.rays.size(), which.size()),
                  "run the command again; fewer --rays take less time");
  basis.start_s = cpu_seconds();
  for (const auto& ray : solved.rays) basis.start_s -= seconds_of(ray);
  basis.start_s -= seconds_of(solved.rays.front());
  for (const double s : solved.node_setup_s) basis.start_s -= s;
  basis.start_s = std::max(0.0, basis.start_s - solved.node_setup_s.front());
  return solved;
}

}  // namespace

PlanBasis basis_of_scene(const PlanOptions& options) {
  const SolverSession session;
  const auto loaded = load_scene(options.source);
  install_stop_handler();  // a signal before ends the program: there is nothing to keep
  const auto header = database_header(loaded.scene, loaded.mesh, loaded.sets);
  const auto requested = requested_rays(loaded.scene, loaded.mesh, header);
  const auto chosen = choose(header, requested, options);
  if (chosen.empty())
    throw input_error("the scene has no rays", options.source.string(), "check nodes.active and the directions");
  ProbeSolver solver(loaded.scene, loaded.mesh, loaded.sets);

  PlanBasis basis;
  const auto solved = solve(solver, header, chosen, basis);
  basis.memory_bytes = peak_memory_bytes();
  RaySample sample;
  sample.rays = chosen;
  for (const auto& ray : solved.rays) {
    sample.seconds.push_back(seconds_of(ray));
    for (const auto status : ray.status) ++basis.states[status];
  }
  std::vector<RayEnd> ends(requested.size(), RayEnd{EndReason::not_requested});
  for (const auto& ray : solved.rays)
    ends[static_cast<std::size_t>(ray.active) * header.directions.size() + static_cast<std::size_t>(ray.direction)] =
        ray.end;
  basis.header = header;
  basis.ends = summarize_ends(header, ends);
  const auto rays = rays_left(header, std::vector<char>(requested.size(), 0));
  basis.work = work_like(sample, rays, requested, header.directions.size(), static_cast<std::uint64_t>(options.seed));
  basis.increments = static_cast<int>(header.magnitudes_m.size());
  basis.rays_mirrored = static_cast<std::int64_t>(requested.size() - rays.size());
  basis.relative_error = sample.relative_error();
  basis.rays_measured = static_cast<std::int64_t>(chosen.size());
  basis.nodes_measured = static_cast<std::int64_t>(solved.node_setup_s.size());
  basis.rays_requested = std::count(requested.begin(), requested.end(), char{1});
  basis.node_setup_s = std::accumulate(solved.node_setup_s.begin(), solved.node_setup_s.end(), 0.0) /
                       static_cast<double>(solved.node_setup_s.size());
  basis.packing = try_packing(header, solved.rays, std::filesystem::temp_directory_path());
  basis.work.bytes_per_ray = basis.packing.record_bytes;
  basis.model = predict_model_size(loaded.scene, header);
  return basis;
}

}  // namespace phynness::cli
