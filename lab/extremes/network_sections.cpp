#include <fmt/core.h>

#include <cmath>
#include <phynness/training/spread_search.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <random>

#include "model_body.hpp"
#include "sections.hpp"

namespace phynness::extremes {
namespace {

/// Means of |network - data| over the points, over the largest |data|: (17) for one node.
struct Fit {
  double training = 0, fresh = 0;
};

struct Truth {
  Vec3 d{}, force_N{};
  Points u;  ///< at the output nodes
};

/// New solves of a node within its trained depths.
std::vector<Truth> fresh_solves(const ModelBody& body, const study::StudyNode& node, ProbeSolver& solver,
                                const TrainingTables& tables, int n_rays, std::mt19937_64& random) {
  const auto described = describe_node(tables, node.node, node.point, node.tool, node.rays);
  const auto& directions = body.data.header.directions;
  solver.touch({node.node});
  std::vector<Truth> found;
  for (int ray = 0; ray < n_rays;) {
    const Vec3 e = on_sphere(random);
    std::size_t nearest = 0;
    const auto cosine = [&](std::size_t j) {
      return e[0] * directions[j][0] + e[1] * directions[j][1] + e[2] * directions[j][2];
    };
    for (std::size_t j = 1; j < directions.size(); ++j)
      if (cosine(j) > cosine(nearest)) nearest = j;
    const double R = described.trained_depth_m[nearest];
    if (R <= 0) continue;
    ++ray;
    std::vector<double> depths{R * uniform(random), R * uniform(random)};
    std::sort(depths.begin(), depths.end());
    solver.follow({e}, depths, false, [&](std::size_t i, const Response& r) {
      if (r.status != Status::converged) return false;
      found.push_back({{depths[i] * e[0], depths[i] * e[1], depths[i] * e[2]},
                       r.force_N[0],
                       at_output(r.displacement_m, body.data.header.sets.output)});
      return true;
    });
  }
  return found;
}

NetworkPoints points_of(const std::vector<Truth>& truths, const TrainingTables& tables, std::int32_t touched,
                        bool deformation) {
  NetworkPoints points;
  const auto n = static_cast<Eigen::Index>(truths.size()), n_output = tables.output_points.rows();
  points.displacements.resize(n, 3);
  std::vector<Eigen::Vector3d> outputs;
  if (deformation) points.places = tables.output_points;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& truth = truths[static_cast<std::size_t>(i)];
    points.displacements.row(i) = Eigen::RowVector3d(truth.d[0], truth.d[1], truth.d[2]);
    if (!deformation) {
      points.displacement.push_back(static_cast<std::int32_t>(i));
      outputs.emplace_back(truth.force_N[0], truth.force_N[1], truth.force_N[2]);
      continue;
    }
    for (Eigen::Index o = 0; o < n_output; ++o) {
      if (tables.output[static_cast<std::size_t>(o)] == touched) continue;
      points.displacement.push_back(static_cast<std::int32_t>(i));
      points.place.push_back(static_cast<std::int32_t>(o));
      outputs.emplace_back(truth.u.row(o));
    }
  }
  points.outputs.resize(static_cast<Eigen::Index>(outputs.size()), 3);
  for (std::size_t i = 0; i < outputs.size(); ++i) points.outputs.row(static_cast<Eigen::Index>(i)) = outputs[i];
  return points;
}

Fit fit(const NetworkPoints& training, const NetworkPoints& fresh, int neurons, double spread, int& grown) {
  FitOptions options;
  options.max_neurons = neurons;
  options.spread = spread;
  const auto network = fit_network(training, options).network;
  grown = std::max(grown, static_cast<int>(network.weights.rows()));
  return {mean_relative_error(network, training), mean_relative_error(network, fresh)};
}

}  // namespace

void overfitting(const SolverSession&) {
  constexpr int n_nodes = 6, n_rays = 40;
  const auto body = solve_body("liver_case2.toml", 0, n_nodes);
  const TrainingTables tables = training_tables(body.data.header);
  ProbeSolver solver(body.scene, body.mesh(), body.data.header.sets);
  std::mt19937_64 random(1);
  std::vector<NetworkPoints> force, force_fresh, field, field_fresh;
  std::size_t most = 0, least = 1000000;
  const std::size_t n_directions = body.data.header.directions.size(),
                    n_increments = body.data.header.magnitudes_m.size();
  for (const auto& node : body.data.probed) {
    const auto truths = fresh_solves(body, node, solver, tables, n_rays, random);
    force.push_back(force_points(tables, node.rays));
    field.push_back(deformation_points(tables, node.rays, node.tool, node.node, 5000, 1));
    force_fresh.push_back(points_of(truths, tables, node.node, false));
    field_fresh.push_back(points_of(truths, tables, node.node, true));
    most = std::max(most, force.back().size());
    least = std::min(least, force.back().size());
  }
  fmt::print(
      "\nOver-fitting: the paper's Case 2 ({}, {}, K/mu = {:.3g}, {} nodes, {} probes to {:g} mm,\n"
      "{} x {}), {} nodes; {} to {} of {} increments converge. Networks of family rbfn without the limit of "
      "{:g} of\n"
      "the points; means over the nodes of (17), in %, at training points and at {} fresh solves a node, and "
      "the\n"
      "worst node's\n",
      name(body.scene.material.law), name(body.scene.solver.element), body.scene.material.bulk_to_shear(),
      body.mesh().n_nodes(), name(body.scene.probe.kind), 1e3 * body.scene.probe.max_displacement_m, n_directions,
      n_increments, body.data.probed.size(), least, most, n_directions * n_increments, largest_neuron_share,
      2 * n_rays);
  const auto table = [&](const char* what, const std::vector<NetworkPoints>& training,
                         const std::vector<NetworkPoints>& fresh, const std::vector<int>& sizes,
                         const std::vector<double>& spreads) {
    fmt::print("{:<24}", fmt::format("{}, neurons", what));
    for (const double spread : spreads)
      fmt::print("{:>40}", fmt::format("spread {:g}: training, fresh, worst", spread));
    fmt::print("\n");
    for (const int n : sizes) {
      fmt::print("{:<24}", n);
      for (const double spread : spreads) {
        Fit mean;
        double worst = 0;
        int grown = 0;
        for (std::size_t i = 0; i < training.size(); ++i) {
          const auto one = fit(training[i], fresh[i], n, spread, grown);
          mean.training += one.training / static_cast<double>(training.size());
          mean.fresh += one.fresh / static_cast<double>(training.size());
          worst = std::max(worst, one.fresh);
        }
        fmt::print("{:>12}{:>12.3g}{:>8.3g}{:>8.3g}", grown < n ? fmt::format("({})", grown) : "", 100 * mean.training,
                   100 * mean.fresh, 100 * worst);
      }
      fmt::print("\n");
      std::fflush(stdout);
    }
  };
  table("force", force, force_fresh, {10, 25, 50, 75, 100, 125, 150}, {0.375, 0.75, 1.5, 3});
  table("deformation", field, field_fresh, {25, 50, 75, 100, 200, 400, 800}, {0.75, 1.5});
}

}  // namespace phynness::extremes
