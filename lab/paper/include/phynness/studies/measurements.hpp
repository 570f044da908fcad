// Measurements of the study of the paper as plain numbers. Errors are fractions, normalized as in (17) by the largest
// finite element response of the same node and the same group of test points.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace phynness {

/// Numbers of measurements.
struct StudySizes {
  int nodes = 10;            ///< active nodes, two of ten beside the fixed nodes
  int probes_per_node = 20;  ///< random directions, each with one probe inside the trained range and one outside
  std::vector<int> neurons{10, 20, 35, 50, 75, 100, 150, 200, 250, 300};
  std::vector<int> histogram_neurons{20, 100, 300};
  std::vector<double> spreads{0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0, 3.0};
  std::vector<int> samples{500, 1000, 2000, 3000, 4000, 5000, 6000, 8000};
  std::vector<int> force_neurons{5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 90, 95};
  std::vector<int> curve_neurons{50, 75, 100};
  int study_neurons = 200;  ///< neurons in the studies of spread and samples
  int training_pairs = 5000, test_pairs = 3000;
  int force_training_pairs = 100, force_test_pairs = 30;
  int curve_points = 10;
  int tool_pairs = 60;  ///< pairs of two tools
  std::uint64_t seed = 11;
};

/// Errors of networks of one size, spread or number of samples at one node.
struct NetworkErrors {
  double x = 0;                        ///< neurons, spread or training pairs
  int neurons = 0;                     ///< trained neurons; fewer than requested if points are dependent
  double held_mean = 0, held_max = 0;  ///< the paper's test: pairs of the same database that were not used in training
  double fresh_mean = 0, fresh_max = 0;    ///< new solves in random directions inside the trained range
  double beyond_mean = 0, beyond_max = 0;  ///< outside of the trained range
};

/// Counts of errors in bins of `error_bin`; the last bin contains all larger errors.
using Histogram = std::vector<std::int64_t>;
inline constexpr double error_bin = 0.005;
inline constexpr int n_error_bins = 60;

struct ErrorHistogram {
  int neurons = 0;
  Histogram held, fresh;
};

/// Errors of a model or of a trivial predictor at one node for the new solves.
struct PredictorAtNode {
  double force = 0, force_max = 0, displacement = 0;                       ///< inside: mean, max, mean
  double force_beyond = 0, force_beyond_max = 0, displacement_beyond = 0;  ///< outside
};

/// Component of the force [N] along the inward normal against depth [m].
struct ForceCurves {
  std::vector<double> depth_m, finite_elements, linear, ours;
  std::vector<std::vector<double>> networks;  ///< by StudySizes::curve_neurons
};

struct NodeMeasurements {
  std::int32_t node = 0;
  bool beside_fixed = false;
  std::int64_t failed = 0;                                       ///< new probes that the finite elements did not solve
  std::vector<NetworkErrors> by_neurons, by_spread, by_samples;  ///< deformation networks
  std::vector<NetworkErrors> force_as_paper;  ///< held_*: pairs divided as in the paper; fresh_*: the same networks
  std::vector<NetworkErrors> force_all;       ///< trained on all increments; held_* are 0
  std::vector<ErrorHistogram> histograms;
  ForceCurves curves;
  PredictorAtNode ours, linear, zero;
  double stiffness_N_per_m = 0;  ///< at rest along the normal
  double training_cpu_s = 0;     ///< of both networks, including data extraction
};

/// Two tools at random nodes in exploratory directions, at one depth of the deeper tool.
struct TwoToolErrors {
  double depth_m = 0;
  double paper_mean = 0, coupled_mean = 0, linear_mean = 0;  ///< over output nodes
  double paper_max = 0, coupled_max = 0, linear_max = 0;
  /// Errors of the force of the tool with the larger error, over the largest force.
  double coupled_force = 0, linear_force = 0, alone_force = 0;
  Histogram paper, coupled, linear;  ///< of output nodes
};
struct ToolPair {
  std::int32_t a = 0, b = 0;
  double distance_m = 0;
  std::array<double, 3> first{}, second{};  ///< displacements per metre of the deeper tool's depth
  std::vector<TwoToolErrors> depths;        ///< solved depths
};

struct CaseMeasurements {
  std::string law, element;
  double bulk_to_shear = 0, range_m = 0, outside_factor = 0;
  double force_spread = 0, deformation_spread = 0;
  std::string ours;              ///< family of the model that is compared with the networks
  std::int64_t data_points = 0;  ///< points of the data of one deformation network
  double seconds = 0;
  StudySizes sizes;
  std::vector<NodeMeasurements> nodes;
  std::vector<ToolPair> pairs;
};

/// Times of the runtime on one core of this machine: medians of processor time [us].
struct SurfaceLevel {
  std::int32_t vertices = 0, triangles = 0;
  double network_us = 0;       ///< networks at the nodes with Loop's weights
  double every_vertex_us = 0;  ///< (11)-(12) at every vertex with one exponential per neuron, as in the paper
  double ours_us = 0;          ///< the other family with Loop's weights
};
struct RuntimeTimes {
  double force_us = 0, deformation_us = 0, deformation_plain_us = 0;
  double ours_force_us = 0, ours_deformation_us = 0;
  int neurons = 0, force_neurons = 0;
  std::vector<SurfaceLevel> levels;
};

}  // namespace phynness
