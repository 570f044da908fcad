#include <cmath>
#include <limits>
#include <phynness/training/node_training.hpp>

#include "sampling.hpp"

namespace phynness {
namespace {

constexpr int n_held_out_deformation = 3000;
constexpr std::size_t held_out_force_divisor = 5;

std::vector<double> candidates(double first, int n) {
  std::vector<double> spreads;
  for (int i = 0; i < n; ++i) spreads.push_back(first * std::pow(2.0, 0.5 * i));
  return spreads;
}

struct Split {
  NetworkPoints train, held_out;
};

double best_spread(const std::vector<Split>& splits, const std::vector<double>& spreads, int neurons,
                   double target_mse) {
  double best = 0, smallest = std::numeric_limits<double>::infinity();
  for (const double spread : spreads) {
    double error = 0;
    for (const Split& split : splits) {
      const NetworkFit fit =
          fit_network(split.train, {capped_neurons(neurons, split.train.size()), spread, target_mse});
      error += mean_relative_error(fit.network, split.held_out);
    }
    if (!splits.empty() && error < smallest) {
      smallest = error;
      best = spread;
    }
  }
  return best;
}

NetworkPoints subset(const NetworkPoints& points, const std::vector<std::int32_t>& rows) {
  NetworkPoints part;
  part.displacements = points.displacements;
  part.outputs = points.outputs(rows, Eigen::all);
  for (const auto row : rows) part.displacement.push_back(points.displacement[row]);
  return part;
}

}  // namespace

std::vector<double> deformation_spread_candidates() { return candidates(0.375, 6); }
std::vector<double> force_spread_candidates() { return candidates(0.5, 8); }

double mean_relative_error(const RbfNetwork& network, const NetworkPoints& points) {
  double sum = 0, largest = 0;
  Eigen::VectorXd inputs(points.n_inputs());
  for (std::size_t p = 0; p < points.size(); ++p) {
    inputs.head(points.displacements.cols()) = points.displacements.row(points.displacement[p]);
    if (!points.place.empty()) inputs.tail(points.places.cols()) = points.places.row(points.place[p]);
    const Eigen::Vector3d data = points.outputs.row(static_cast<Eigen::Index>(p));
    sum += (evaluate(network, inputs) - data).norm();
    largest = std::max(largest, data.norm());
  }
  return largest > 0 ? sum / (static_cast<double>(points.size()) * largest) : 0;
}

double search_force_spread(const TrainingTables& tables, const std::vector<SearchNode>& nodes,
                           const TrainingSpec& spec) {
  std::vector<Split> splits;
  for (const SearchNode& node : nodes) {
    const NetworkPoints points = force_points(tables, node.rays);
    if (points.size() < 2 * held_out_force_divisor) continue;
    SplitMix64 random(node_seed(spec.seed, node.node));
    const auto drawn = draw_without_replacement(points.size(), points.size(), random);
    const auto cut = drawn.begin() + static_cast<std::ptrdiff_t>(points.size() / held_out_force_divisor);
    splits.push_back({subset(points, {cut, drawn.end()}), subset(points, {drawn.begin(), cut})});
  }
  return best_spread(splits, force_spread_candidates(), spec.force_neurons, spec.target_mse);
}

double search_deformation_spread(const TrainingTables& tables, const std::vector<SearchNode>& nodes,
                                 const TrainingSpec& spec) {
  std::vector<Split> splits;
  for (const SearchNode& node : nodes) {
    Split split;
    split.train = deformation_points(tables, node.rays, node.tool, node.node, spec.samples, spec.seed, &split.held_out,
                                     n_held_out_deformation);
    // In a small set of responses all points are samples, and a part of the samples is held out.
    if (split.held_out.size() < split.train.size() / 10) {
      const int n = static_cast<int>(split.train.size() + split.held_out.size());
      split.train =
          deformation_points(tables, node.rays, node.tool, node.node, n - n / 5, spec.seed, &split.held_out, n / 5);
    }
    if (split.train.size() >= 10 && split.held_out.size() > 0) splits.push_back(std::move(split));
  }
  return best_spread(splits, deformation_spread_candidates(), spec.deformation_neurons, spec.target_mse);
}

}  // namespace phynness
