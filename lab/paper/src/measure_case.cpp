#include <algorithm>
#include <chrono>
#include <ctime>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/studies/measure.hpp>
#include <phynness/training/node_training.hpp>
#include <phynness/validation/probed_states.hpp>

#include "force_curves.hpp"
#include "two_tools.hpp"

namespace phynness {
namespace {

using namespace study;

constexpr std::size_t searched_nodes = 3;  // whose forces determine the spread for all nodes

PredictorAtNode at_node(const PredictorErrors& e) {
  return {e.inside.force.mean,  e.inside.force.max,  e.inside.displacement.mean,
          e.outside.force.mean, e.outside.force.max, e.outside.displacement.mean};
}

/// CPU time of one core for both networks of a node, including the reading of the database.
double training_cpu_s(const NodeData& data, std::int32_t node, TrainingSpec spec, double force_spread) {
  spec.force_spread = force_spread;
  spec.levels = 1;
  const std::clock_t start = std::clock();
  const auto rays = data.rays(node);
  const auto x = data.header().mesh.nodes.row(node);
  train_node(data.tables(), node, {x[0], x[1], x[2]}, data.touched(node), rays, spec, false);
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

double chosen_force_spread(const NodeData& data, const std::vector<NodePlan>& plan, const Scene& scene) {
  std::vector<SearchNode> nodes;
  for (std::size_t i = 0; i < std::min(searched_nodes, plan.size()); ++i) {
    const auto node = plan[i * plan.size() / std::min(searched_nodes, plan.size())].node;
    nodes.push_back({node, data.touched(node), data.rays(node)});
  }
  const double spread = search_force_spread(data.tables(), nodes, scene.training);
  if (!(spread > 0))
    throw input_error("too few increments to train force networks on", scene.source_name,
                      "use a scene with more directions or increments");
  return spread;
}

}  // namespace

CaseMeasurements measure_case(const SolverSession& session, const Scene& scene, const Database& database,
                              const NamedOrgan* networks, const NamedOrgan& ours, const StudySizes& sizes,
                              bool two_tools, const StudyProgress& progress) {
  const auto start = std::chrono::steady_clock::now();
  if (physics_hash(scene) != database.header().physics_hash)
    throw input_error("the database belongs to another scene", scene.source_name,
                      "remove it, or give the study another folder");
  const bool linear = scene.material.law->linear;
  const NodeData data(database, linear);
  const auto say = [&](const char* what, std::int64_t done, std::int64_t total) {
    if (session.rank() == 0) progress(what, done, total);
  };
  CaseMeasurements out;
  out.law = name(scene.material.law);
  out.element = name(scene.solver.element);
  out.bulk_to_shear = scene.material.bulk_to_shear();
  out.range_m = scene.probe.max_displacement_m;
  out.outside_factor = outside_factor;
  out.ours = name(ours.model().family);
  out.sizes = sizes;
  out.data_points = static_cast<std::int64_t>(data.tables().displacements.rows()) *
                    (static_cast<std::int64_t>(data.tables().output.size()) - 1);
  const auto plan =
      plan_probes(ours, scene.probe.directions, 2L * sizes.probes_per_node * sizes.nodes, sizes.seed, sizes.nodes);
  out.deformation_spread = scene.training.deformation_spread > 0 ? scene.training.deformation_spread : 0.75;
  out.force_spread = chosen_force_spread(data, plan, scene);

  const Points normals = node_normals(ours.mesh());
  ProbeSolver solver(scene, ours.mesh(), {ours.model().fixed, {}, ours.model().output});
  const double deepest = outside_factor * scene.probe.max_displacement_m;
  std::int64_t measured = 0;
  solve_probes(
      session, scene, ours, plan,
      [&](std::int64_t done, std::int64_t total) { say("probes and networks", done, total); }, {},
      [&](std::size_t entry, NodeProbes&& probes) {
        const auto node = plan[entry].node;
        const NodeUnderStudy study{
            data, probes, data.touched(node), data.rays(node), out.deformation_spread, out.force_spread};
        NodeMeasurements m;
        m.node = node;
        m.beside_fixed = plan[entry].beside_fixed;
        m.failed = probes.failed;
        measure_deformation(study, sizes, m);
        measure_forces(study, sizes, m);
        const Eigen::RowVector3d n = normals.row(node);
        measure_curves(solver, study, ours, {-n[0], -n[1], -n[2]}, deepest, sizes, m);
        m.ours = at_node(model_errors(ours, {probes}));
        m.linear = at_node(linear_errors({probes}));
        m.training_cpu_s = training_cpu_s(data, node, scene.training, out.force_spread);
        out.nodes.push_back(std::move(m));
        ++measured;
      });
  if (two_tools && networks != nullptr) {
    std::mt19937_64 random(sizes.seed);
    const auto& magnitudes = database.header().magnitudes_m;
    for (int p = 0; p < sizes.tool_pairs; ++p) {
      const auto pair = draw_pair(networks->model(), random);  // every rank draws all
      if (p % session.size() != session.rank()) continue;
      out.pairs.push_back(measure_pair(solver, pair, magnitudes, *networks, ours));
      say("two tools", p + 1, sizes.tool_pairs);
    }
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

CaseMeasurements merged(const std::vector<CaseMeasurements>& parts) {
  CaseMeasurements all = parts.front();
  all.nodes.clear();
  all.pairs.clear();
  std::size_t nodes = 0, pairs = 0;
  for (const auto& part : parts) {
    nodes = std::max(nodes, part.nodes.size());
    pairs = std::max(pairs, part.pairs.size());
    all.seconds = std::max(all.seconds, part.seconds);
  }
  // Nodes are distributed to ranks in turn, so that the order of the results does not depend on the number of ranks.
  for (std::size_t i = 0; i < nodes; ++i)
    for (const auto& part : parts)
      if (i < part.nodes.size()) all.nodes.push_back(part.nodes[i]);
  for (std::size_t i = 0; i < pairs; ++i)
    for (const auto& part : parts)
      if (i < part.pairs.size()) all.pairs.push_back(part.pairs[i]);
  return all;
}

}  // namespace phynness
