#include "model_body.hpp"

#include <fmt/core.h>

#include <phynness/formats/hash.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/training/training.hpp>

#include "console.hpp"
#include "robustness/bodies.hpp"

namespace phynness::extremes {

ModelBody solve_body(const std::string& scene_name, double depth_m, int most_active) {
  auto loaded = robustness::load(std::string(PHYNNESS_SCENES) + "/" + scene_name);
  ModelBody body;
  body.scene = loaded.scene;
  if (depth_m > 0) body.scene.probe.max_displacement_m = depth_m;
  if (most_active > 0) loaded.sets.active = robustness::draw_nodes(loaded.sets, most_active, 1);
  auto& header = body.data.header;
  header = database_header(body.scene, loaded.mesh, loaded.sets);
  header.mesh_hash = mesh_hash(loaded.mesh);
  header.physics_hash = physics_hash(body.scene);
  ProbeSolver solver(body.scene, header.mesh, header.sets);
  cli::Progress progress("solve", "nodes");
  const auto n_nodes = static_cast<std::int32_t>(header.sets.active.size());
  for (std::int32_t a = 0; a < n_nodes; ++a) {
    std::vector<std::pair<std::int32_t, std::int32_t>> which;
    for (std::size_t e = 0; e < header.directions.size(); ++e) which.emplace_back(a, static_cast<std::int32_t>(e));
    const std::int32_t node = header.sets.active[static_cast<std::size_t>(a)];
    const auto x = header.mesh.nodes.row(node);
    body.data.probed.push_back(
        {node,
         {x[0], x[1], x[2]},
         touched_nodes(header.mesh.nodes, header.mesh.surface, header.sets.fixed, at_node(node), 0),
         solve_rays(solver, header, which, {}, {}).rays});
    progress.update(a + 1, n_nodes);
  }
  return body;
}

TrainingSpec training_of(const Scene& scene, Family family) {
  TrainingSpec spec = scene.training;
  spec.family = family;
  return spec;
}

LoadedModel train_on(const study::StudyData& data, const TrainingSpec& spec) {
  TrainingReport report;
  ResponseSource source;
  source.header = &data.header;
  source.rays = [&](std::int32_t a) { return data.probed[static_cast<std::size_t>(a)].rays; };
  source.title = "the study's body";
  return LoadedModel(train(source, spec, report), data.header.mesh, "the study's model");
}

void Errors::add_node(const std::vector<Compared>& probes, Eigen::Index without) {
  double largest_force = 0, largest_u = 0;
  for (const auto& p : probes) {
    largest_force = std::max(largest_force, p.force_FE.norm());
    for (Eigen::Index o = 0; o < p.u_FE.rows(); ++o)
      if (o != without) largest_u = std::max(largest_u, p.u_FE.row(o).norm());
  }
  for (const auto& p : probes) {
    _force.push_back((p.force - p.force_FE).norm() / largest_force);
    for (Eigen::Index o = 0; o < p.u_FE.rows(); ++o)
      if (o != without) _displacement.push_back((p.u.row(o) - p.u_FE.row(o)).norm() / largest_u);
  }
}

Points at_output(const Points& all, const std::vector<std::int32_t>& output) {
  Points rows(static_cast<Eigen::Index>(output.size()), 3);
  for (std::size_t o = 0; o < output.size(); ++o) rows.row(static_cast<Eigen::Index>(o)) = all.row(output[o]);
  return rows;
}

std::string percent(const ErrorStatistics& e) {
  return fmt::format("{:>8.3g}{:>8.3g}{:>9.3g}", 100 * e.mean, 100 * e.p95, 100 * e.max);
}

}  // namespace phynness::extremes
