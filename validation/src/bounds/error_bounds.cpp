// The statistics of the bounds: a regression of the errors on properties of trained states, and the factor with which
// the bounds reach their coverage.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/validation/error_bounds.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <set>
#include <tuple>

namespace phynness {
namespace {

/// Exponent of the predicted error in a bound (docs/decisions/error-bounds.md).
constexpr double shrinkage = 0.8;
/// Candidates for an added power of the depth, because errors mostly spread more at depth. The first candidate is used
/// with which each third of the depth is covered nearly as well as the whole.
constexpr std::array added_depth_powers{0.5, 0.0, -0.5, 1.0};
/// Fewer states cannot determine a quantile of 95 %.
constexpr std::size_t min_states = 200;

constexpr int n_terms = 4;
using Terms = Eigen::Matrix<double, 1, n_terms>;

Terms terms_of(double largest_N, double compression, double depth) {
  return {1, std::log(largest_N), compression, std::log(depth)};
}

double compression_of(double min_jacobian) { return std::log(-std::log(std::clamp(min_jacobian, 1e-4, 1 - 1e-4))); }

/// Interpolates values of trained displacements at a state, linearly between the depths of the nearest direction. The
/// runtime interpolates in the same way, but not to a constant below the first depth.
double interpolated(const Model& model, const std::vector<double>& rows, const BoundState& state) {
  const auto n = static_cast<std::size_t>(model.displacements.rows()) / model.directions.size();
  std::size_t nearest = 0;
  double largest_cosine = -2;
  for (std::size_t k = 0; k < model.directions.size(); ++k) {
    const auto& e = model.directions[k];
    const double cosine = e[0] * state.direction[0] + e[1] * state.direction[1] + e[2] * state.direction[2];
    if (cosine > largest_cosine) {
      largest_cosine = cosine;
      nearest = k;
    }
  }
  double previous_length = 0, previous = rows[nearest * n];
  for (std::size_t j = 0; j < n; ++j) {
    const double length = model.displacements.row(static_cast<Eigen::Index>(nearest * n + j)).norm();
    const double next = rows[nearest * n + j];
    if (state.depth_m < length)
      return previous + (next - previous) * (state.depth_m - previous_length) / (length - previous_length);
    previous_length = length;
    previous = next;
  }
  return previous;
}

Eigen::Vector4d fit(const Model& model, const BoundPredictors& predictors, const std::vector<BoundState>& states) {
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(states.size()), n_terms);
  Eigen::VectorXd errors(static_cast<Eigen::Index>(states.size()));
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto& state = states[i];
    const auto node = static_cast<std::size_t>(state.node);
    const auto row = static_cast<Eigen::Index>(i);
    const double largest = predictors.largest_N[node];
    terms.row(row) = terms_of(largest, interpolated(model, predictors.compression[node], state),
                              state.depth_m / model.max_displacement_m);
    errors[row] = std::log(state.error_N + smallest_error * largest);
  }
  // Columns may be constant: bodies without a J, models of one node.
  return terms.completeOrthogonalDecomposition().solve(errors);
}

/// Rounds the entries of a node's table up. @param c  coefficients of the logarithm of a bound
ScaledTable table_of(const Model& model, std::size_t node, const BoundPredictors& predictors, const Eigen::Vector4d& c,
                     double factor) {
  const auto n = model.displacements.rows();
  Eigen::MatrixXd values(n, 1);
  for (Eigen::Index row = 0; row < n; ++row) {
    const double depth = model.displacements.row(row).norm() / model.max_displacement_m;
    const double value = factor * std::exp(terms_of(predictors.largest_N[node],
                                                    predictors.compression[node][static_cast<std::size_t>(row)],
                                                    std::max(depth, 1e-12)) *
                                           c);
    values(row, 0) = std::isfinite(value) ? std::min(value, schema::largest_table_value) : schema::largest_table_value;
  }
  ScaledTable table = scaled_table(values);
  for (Eigen::Index row = 0; row < n && table.scale[0] > 0; ++row)
    table.entries(row, 0) = static_cast<std::int16_t>(
        std::min<double>(schema::largest_table_entry, std::ceil(values(row, 0) / table.scale[0])));
  return table;
}

/// Sizes of the forces of all nodes at rest, where the true force is 0; 0 in a family with an energy.
std::vector<double> forces_at_rest(const Model& model) {
  std::vector<double> sizes(model.nodes.size(), 0.0);
  if (schema::traits(model.family).has_energy) return sizes;
  Mesh mesh;  // it is empty, because forces do not need it
  mesh.cells.resize(0, 4);
  const NamedOrgan loaded(model, mesh, "the model");
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const Vec3 force = loaded.force(model.nodes[i].node, {0, 0, 0});
    sizes[i] = std::hypot(force[0], force[1], force[2]);
  }
  return sizes;
}

/// Ratios of the errors and the bounds with the factor 1.
std::vector<double> scores_of(const Model& model, const BoundPredictors& predictors,
                              const std::vector<BoundState>& states, const std::vector<double>& rest_force,
                              const Eigen::Vector4d& coefficients) {
  std::vector<std::vector<double>> values(model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const Eigen::VectorXd column = table_of(model, i, predictors, coefficients, 1).values().col(0);
    values[i].assign(column.begin(), column.end());
  }
  std::vector<double> scores;
  for (const auto& state : states) {
    // Below the first displacement the bound is linear. It begins at the force at rest, which has no factor.
    const auto node = static_cast<std::size_t>(state.node);
    const double fraction = std::min(1.0, state.depth_m / model.displacements.row(0).norm());
    const double scaled_error = state.error_N - (1 - fraction) * rest_force[node];
    scores.push_back(std::max(scaled_error, 0.0) /
                     std::max(fraction * interpolated(model, values[node], state), 1e-300));
  }
  return scores;
}

/// The smallest share, over the thirds of the depth, of scores that are at most `factor`.
double least_third(const Model& model, const std::vector<BoundState>& states, const std::vector<double>& scores,
                   double factor) {
  std::vector<BoundedError> errors;
  for (std::size_t i = 0; i < states.size(); ++i) errors.push_back({states[i].depth_m, scores[i], factor});
  double least = 1;
  for (const double third : coverage_of(errors, model.max_displacement_m).thirds) least = std::fmin(least, third);
  return least;
}

}  // namespace

BoundPredictors bound_predictors(const Model& model, const Database& database) {
  const auto& header = database.header();
  for (const auto& [what, own, other] : {std::tuple{"mesh", model.mesh_hash, header.mesh_hash},
                                         std::tuple{"physics", model.physics_hash, header.physics_hash}})
    if (own != other)
      throw input_error("the model was not trained on this database",
                        std::string(what) + " hash " + own + ", of the database " + other,
                        "give the database on which the model was trained");
  BoundPredictors predictors;
  const auto n_rows = static_cast<std::size_t>(model.displacements.rows());
  for (const auto& node : model.nodes) {
    const auto& active = header.sets.active;
    const auto found = std::lower_bound(active.begin(), active.end(), node.node);
    if (found == active.end() || *found != node.node)
      throw input_error("the database has no rays of a node of the model", "node " + std::to_string(node.node),
                        "give the database on which the model was trained");
    auto& compression = predictors.compression.emplace_back(n_rows, compression_of(0));
    double largest = 0;
    std::size_t row = 0;
    for (const auto& ray : database.rays(static_cast<std::int32_t>(found - active.begin())))
      for (std::size_t i = 0; i < ray.status.size() && row < n_rows; ++i, ++row) {
        if (ray.status[i] != Status::converged) continue;
        compression[row] = compression_of(ray.min_jacobian[i]);
        largest = std::max(largest, std::hypot(ray.force[3 * i], ray.force[3 * i + 1], ray.force[3 * i + 2]));
      }
    predictors.largest_N.push_back(largest > 0 ? largest : 1);
  }
  return predictors;
}

Model add_bounds(Model model, const BoundPredictors& predictors, const std::vector<BoundState>& states,
                 std::int64_t n_rays, double coverage) {
  if (states.size() < min_states)
    throw input_error("there are too few states inside the trained range to calibrate bounds",
                      std::to_string(states.size()) + " states", "use more --rays; 1000 rays give about 3000 states");
  std::set<std::int32_t> nodes;
  for (const auto& state : states) nodes.insert(state.node);
  const std::size_t n_nodes = nodes.size();
  const Eigen::Vector4d fitted = shrinkage * fit(model, predictors, states);
  const auto rest_force = forces_at_rest(model);
  // The clusters of the sample are the nodes, or the rays if every node is sampled.
  const auto n = static_cast<double>(independent_errors(model, std::ssize(nodes), n_rays));
  double best = -1;
  for (const double power : added_depth_powers) {
    Eigen::Vector4d coefficients = fitted;
    coefficients[3] += shrinkage * power;
    const auto scores = scores_of(model, predictors, states, rest_force, coefficients);
    auto ascending = scores;
    std::ranges::sort(ascending);
    const double factor = quantile(ascending, coverage * (1 + 1 / n));
    const double least = least_third(model, states, scores, factor);
    if (least <= best) continue;
    best = least;
    for (std::size_t i = 0; i < model.nodes.size(); ++i)
      model.nodes[i].bounds = {table_of(model, i, predictors, coefficients, factor)};
    if (least >= coverage - thirds_tolerance) break;
  }
  model.bounds = {{coverage, static_cast<std::int32_t>(n_rays), static_cast<std::int32_t>(n_nodes)}};
  return model;
}

std::vector<BoundedError> bounded_errors(const NamedOrgan& bounded, const std::vector<BoundState>& states) {
  std::vector<BoundedError> out;
  const Model& model = bounded.model();
  for (const auto& state : states) {
    Vec3 d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = state.depth_m * state.direction[k];
    const auto node = static_cast<std::size_t>(state.node);
    const auto bound = bounded.error_bound(model.nodes[node].node, d);
    out.push_back({state.depth_m, state.error_N, bound.value_or(0)});
  }
  return out;
}

}  // namespace phynness
