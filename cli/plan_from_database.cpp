#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>
#include <phynness/formats/ray_tasks.hpp>

#include "console.hpp"
#include "plan.hpp"

namespace phynness::cli {

PlanBasis basis_of_database(const PlanOptions& options) {
  install_stop_handler();
  const auto database = Database::open(options.source);
  const auto& header = database.header();
  const MirroredRays mirrored(header);
  PlanBasis basis;
  basis.increments = static_cast<int>(header.magnitudes_m.size());
  basis.work.rays = rays_left(header, std::vector<char>(header.sets.active.size() * header.directions.size(), 0));
  std::vector<Ray> tried;  // for the packing trial: rays of nodes spread over the file
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
  basis.header = header;
  basis.ends = summarize_ends(database);
  basis.rays_measured = basis.rays_requested;
  basis.nodes_measured = static_cast<std::int64_t>(n_solving);
  basis.packing = try_packing(header, tried, std::filesystem::temp_directory_path());
  basis.work.bytes_per_ray = basis.packing.record_bytes;
  const Scene scene = stored_scene(header);
  warn_of_patch(scene, header.mesh, header.sets);
  basis.model = predict_model_size(scene, header);
  return basis;
}

}  // namespace phynness::cli
