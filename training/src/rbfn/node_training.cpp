#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/training/node_training.hpp>

#include "sampling.hpp"

namespace phynness {
namespace {

/// @param vector  3 numbers
void require_finite(const double* vector, const char* what) {
  if (!Eigen::Map<const Eigen::Vector3d>(vector).allFinite())
    throw failure(std::string("the database has a ") + what + " that is not finite in a converged increment", "",
                  "precompute this database again");
}

/// The deformation where nothing is known of it.
NetworkFit without_neurons(int n_levels) {
  NetworkFit fit;
  fit.network.input_center = Eigen::VectorXd::Zero(6);
  fit.network.input_half_range = Eigen::VectorXd::Ones(6);
  fit.network.output_center = Eigen::VectorXd::Zero(3);
  fit.network.output_half_range = Eigen::VectorXd::Ones(3);
  fit.network.centers.resize(0, 6);
  fit.network.weights.resize(0, 3);
  fit.mse = {0};
  if (n_levels > 1) fit.levels.resize(static_cast<std::size_t>(n_levels));
  for (auto& level : fit.levels) level.neurons.weights.resize(0, 3);
  return fit;
}

}  // namespace

TrainingTables training_tables(const DatabaseHeader& header) {
  TrainingTables tables;
  tables.n_increments = static_cast<std::int32_t>(header.magnitudes_m.size());
  tables.magnitudes_m = header.magnitudes_m;
  tables.float64 = header.float64;
  tables.displacements = prescribed_displacements(header);
  tables.output = header.sets.output;
  tables.output_points = header.mesh.nodes(tables.output, Eigen::all);
  return tables;
}

std::vector<std::int32_t> converged_increments(const TrainingTables& tables, const std::vector<Ray>& rays) {
  std::vector<std::int32_t> found;
  for (std::size_t direction = 0; direction < rays.size(); ++direction)
    for (std::int32_t i = 0; i < tables.n_increments; ++i)
      if (rays[direction].status[i] == Status::converged)
        found.push_back(static_cast<std::int32_t>(direction) * tables.n_increments + i);
  return found;
}

TrainingStates training_states(const TrainingTables& tables, const std::vector<Ray>& rays) {
  TrainingStates states{converged_increments(tables, rays), {}};
  const std::int32_t n = tables.n_increments;
  std::vector<std::int32_t> deepest;  // row of each ray with a converged increment
  for (const std::int32_t row : states.row) {
    if (!deepest.empty() && deepest.back() / n == row / n) deepest.pop_back();
    deepest.push_back(row);
  }
  const auto n_rays = std::max<std::size_t>(1, deepest.size());
  const bool all = states.row.size() <= max_training_states;
  const auto kept = all ? n : static_cast<std::int32_t>(std::max<std::size_t>(1, max_training_states / n_rays));
  for (std::int64_t k = 1; k <= kept; ++k)
    states.increments.push_back(static_cast<std::int32_t>((k * n + kept - 1) / kept - 1));
  if (!all)
    std::erase_if(states.row, [&](std::int32_t row) {
      return !std::binary_search(states.increments.begin(), states.increments.end(), row % n) &&
             !std::binary_search(deepest.begin(), deepest.end(), row);
    });
  return states;
}

ActiveNodeModel describe_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                              const TouchedNodes& tool, const std::vector<Ray>& rays) {
  ActiveNodeModel model;
  model.node = node;
  model.point = point;
  model.moves_mean = tool.mean;
  model.prescribed = tool.nodes;
  model.prescribed_weight = tool.weights;
  for (const Ray& ray : rays) {
    const auto stopped =
        std::find_if(ray.status.begin(), ray.status.end(), [](Status s) { return s != Status::converged; });
    const auto n_good = stopped - ray.status.begin();
    if (stopped != ray.status.end() && ray.status.front() == Status::not_requested) {
      model.trained_depth_m.push_back(std::min(ray.end.depth_m, tables.magnitudes_m.back()));
      continue;
    }
    model.trained_depth_m.push_back(n_good == 0 ? 0 : tables.magnitudes_m[n_good - 1]);
    if (stopped != ray.status.end()) ++model.n_incomplete;
  }
  return model;
}

NetworkPoints force_points(const TrainingTables& tables, const std::vector<Ray>& rays) {
  NetworkPoints points;
  points.displacements = tables.displacements;
  points.displacement = training_states(tables, rays).row;
  points.outputs.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::int32_t row = points.displacement[p];
    const double* force = &rays[row / tables.n_increments].force[3 * (row % tables.n_increments)];
    require_finite(force, "force");
    points.outputs.row(static_cast<Eigen::Index>(p)) << force[0], force[1], force[2];
  }
  return points;
}

NetworkPoints deformation_points(const TrainingTables& tables, const std::vector<Ray>& rays, const TouchedNodes& tool,
                                 std::int32_t node, int samples, std::uint64_t seed, NetworkPoints* held_out,
                                 int n_held_out) {
  const std::vector<std::int32_t> increments = training_states(tables, rays).row;
  std::vector<std::int32_t> places;
  for (std::size_t o = 0; o < tables.output.size(); ++o)
    if (!tool.holds(tables.output[o])) places.push_back(static_cast<std::int32_t>(o));
  const auto n_output = tables.output.size();
  const auto pick = [&](std::vector<std::int32_t> drawn) {
    // Sorted by displacement and then by place, so that tables of a basis column are read in order.
    std::sort(drawn.begin(), drawn.end());
    NetworkPoints points;
    points.displacements = tables.displacements;
    points.places = tables.output_points;
    points.outputs.resize(static_cast<Eigen::Index>(drawn.size()), 3);
    for (std::size_t p = 0; p < drawn.size(); ++p) {
      const std::int32_t row = increments[drawn[p] / places.size()], place = places[drawn[p] % places.size()];
      const Ray& ray = rays[row / tables.n_increments];
      const double* u = &ray.displacement[3 * ((row % tables.n_increments) * n_output + place)];
      require_finite(u, "displacement");
      points.displacement.push_back(row);
      points.place.push_back(place);
      points.outputs.row(static_cast<Eigen::Index>(p)) << u[0], u[1], u[2];
    }
    return points;
  };
  SplitMix64 random(node_seed(seed, node));
  const auto n_train = static_cast<std::size_t>(std::max(samples, 0));
  std::vector<std::int32_t> drawn = draw_without_replacement(
      increments.size() * places.size(), n_train + static_cast<std::size_t>(std::max(n_held_out, 0)), random);
  const auto split = drawn.begin() + static_cast<std::ptrdiff_t>(std::min(n_train, drawn.size()));
  if (held_out) *held_out = pick({split, drawn.end()});
  return pick({drawn.begin(), split});
}

int capped_neurons(int wanted, std::size_t n_points) {
  return std::min(wanted, static_cast<int>(largest_neuron_share * static_cast<double>(n_points)));
}

NodeTraining train_node(const TrainingTables& tables, std::int32_t node, const Vec3& point, const TouchedNodes& tool,
                        const std::vector<Ray>& rays, const TrainingSpec& spec, bool estimate_errors) {
  NodeTraining result;
  const NetworkPoints force = force_points(tables, rays);
  const NetworkPoints deformation = deformation_points(tables, rays, tool, node, spec.samples, spec.seed);
  const bool has_output = !tables.output.empty();
  if (deformation.size() == 0 && has_output)
    throw input_error("the probe moves all output nodes, so that none is left for training",
                      "node " + std::to_string(node), "select more output nodes");
  const auto options = [&](const NetworkPoints& points, int neurons, double spread) {
    FitOptions of_network{capped_neurons(neurons, points.size()), spread, spec.target_mse, spec.levels, {}};
    if (spec.levels > 1 && estimate_errors) of_network.group = points.displacement;
    return of_network;
  };
  result.force = fit_network(force, options(force, spec.force_neurons, spec.force_spread));
  if (has_output) {
    result.deformation =
        fit_network(deformation, options(deformation, spec.deformation_neurons, spec.deformation_spread));
  } else {
    result.deformation = without_neurons(spec.levels);
  }
  result.model = describe_node(tables, node, point, tool, rays);
  result.model.force = result.force.network;
  result.model.deformation = result.deformation.network;
  for (int l = 0; l + 1 < spec.levels; ++l) {
    auto& level = result.model.levels.emplace_back();
    level.force = result.force.levels[static_cast<std::size_t>(l)].neurons;
    level.deformation = result.deformation.levels[static_cast<std::size_t>(l)].neurons;
  }
  return result;
}

}  // namespace phynness
