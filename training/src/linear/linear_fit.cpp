#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/training/linear_fit.hpp>
#include <set>
#include <string>

#include "dense_products.hpp"
#include "dense_solvers.hpp"

namespace phynness {
namespace {

/// The data of one converged increment.
struct Increment {
  Eigen::Vector3d d, force;
  Eigen::Map<const Points> u;  ///< n_output x 3
  const double* energy;        ///< null: not stored, or not known
};

double ratio(double error, double size) { return error == 0 ? 0 : error / size; }

std::vector<Increment> increments_of(const TrainingTables& tables, const std::vector<Ray>& rays,
                                     const std::vector<std::int32_t>& rows) {
  const auto n_output = static_cast<Eigen::Index>(tables.output.size());
  std::vector<Increment> found;
  for (const std::int32_t row : rows) {
    const Ray& ray = rays[row / tables.n_increments];
    const auto i = static_cast<std::size_t>(row % tables.n_increments);
    found.push_back({tables.displacements.row(row).transpose(), Eigen::Vector3d::Map(&ray.force[3 * i]),
                     Eigen::Map<const Points>(ray.displacement.data() + 3 * i * tables.output.size(), n_output, 3),
                     ray.energy.empty() || ray.energy[i] == 0 ? nullptr : &ray.energy[i]});
  }
  return found;
}

/// 3 x n: the pseudo-inverse of the displacements of the increments.
Eigen::MatrixXd pseudo_inverse(const std::vector<Increment>& increments, const TrainingTables& tables,
                               const std::vector<Ray>& rays, std::int32_t node) {
  const auto n = static_cast<Eigen::Index>(increments.size());
  Eigen::MatrixXd d(n, 3), unit(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    d.row(i) = increments[static_cast<std::size_t>(i)].d;
    unit.row(i) = d.row(i).normalized();
  }
  // Squares of singular values suffice, because the smallest relevant one, 1e-4, is far above rounding.
  const Eigen::VectorXd squares = symmetric_eigen(transposed_product(unit, unit)).values;
  if (n < 3 || !(squares[0] > independence_threshold * independence_threshold * squares[2])) {
    std::set<std::int32_t> directions;
    for (const std::int32_t row : converged_increments(tables, rays)) directions.insert(row / tables.n_increments);
    throw input_error("a linear response needs converged increments in three independent directions",
                      "node " + std::to_string(node) + " has " + std::to_string(directions.size()) + " of " +
                          std::to_string(rays.size()) + " directions, which are in one plane",
                      "probe with directions = 3 or 26; if increments failed, `phynness info` lists the reasons");
  }
  return least_squares(d, Eigen::MatrixXd::Identity(n, n));
}

LinearQuality quality_of(const std::vector<Increment>& increments, const LinearResponse& linear) {
  LinearQuality quality;
  for (const Increment& increment : increments) {
    const Eigen::Vector3d& d = increment.d;
    double error = 0, largest = 0;
    for (Eigen::Index o = 0; o < increment.u.rows(); ++o) {
      const auto axes = Eigen::Map<const Eigen::Matrix3d>(linear.unit_responses.row(o).data());
      error = std::max(error, (axes * d - increment.u.row(o).transpose()).norm());
      largest = std::max(largest, increment.u.row(o).norm());
    }
    quality.displacement_residual = std::max(quality.displacement_residual, ratio(error, largest));
    const Eigen::Vector3d force = linear.stiffness * d;
    quality.force_residual =
        std::max(quality.force_residual, ratio((force - increment.force).norm(), increment.force.norm()));
    if (increment.energy)
      quality.energy_residual = std::max(
          quality.energy_residual, ratio(std::abs(force.dot(d) / 2 - *increment.energy), std::abs(*increment.energy)));
  }
  return quality;
}

void require_linear(const LinearQuality& quality, std::int32_t node) {
  const std::pair<const char*, double> checks[] = {
      {"the stiffness differs from its transpose by ", quality.asymmetry},
      {"displacements differ from the best unit responses by ", quality.displacement_residual},
      {"forces differ from the best stiffness by ", quality.force_residual},
      {"energies differ from d.K d / 2 by ", quality.energy_residual}};
  for (const auto& [what, size] : checks)
    if (!(size <= linear_tolerance))
      throw input_error("the scene is not linear",
                        fmt::format("node {}: {}{:.2g} %, at most {:.2g} % is allowed", node, what, 100 * size,
                                    100 * linear_tolerance),
                        "use family rbfn; if the law is linear, tighten [solver] relative_tolerance");
}

}  // namespace

LinearTraining train_linear_node(const TrainingTables& tables, std::int32_t node, const Vec3& point,
                                 const TouchedNodes& tool, const std::vector<Ray>& rays) {
  LinearTraining result;
  const std::vector<Increment> increments = increments_of(tables, rays, training_states(tables, rays).row);
  const Eigen::MatrixXd inverse = pseudo_inverse(increments, tables, rays, node);

  const auto n_output = static_cast<Eigen::Index>(tables.output.size());
  LinearResponse linear;
  linear.unit_responses.setZero(n_output, 9);
  for (std::size_t i = 0; i < increments.size(); ++i) {
    const Eigen::Vector3d share = inverse.col(static_cast<Eigen::Index>(i));
    linear.stiffness += increments[i].force * share.transpose();
    for (int axis = 0; axis < 3; ++axis) linear.unit_responses.middleCols<3>(3 * axis) += share[axis] * increments[i].u;
  }
  if (!linear.stiffness.allFinite() || !linear.unit_responses.allFinite())
    throw failure("the database has a value that is not finite in a converged increment",
                  "node " + std::to_string(node), "precompute this database again");
  const Eigen::Matrix3d skew = linear.stiffness - linear.stiffness.transpose();
  const double asymmetry = ratio(skew.norm(), linear.stiffness.norm());
  linear.stiffness = (linear.stiffness + linear.stiffness.transpose().eval()) / 2;
  result.quality = quality_of(increments_of(tables, rays, converged_increments(tables, rays)), linear);
  result.quality.asymmetry = asymmetry;
  require_linear(result.quality, node);

  if (!tables.float64) linear.unit_responses = linear.unit_responses.cast<float>().cast<double>();
  for (std::size_t i = 0; i < tool.nodes.size() && !tool.mean; ++i) {
    const auto at = std::lower_bound(tables.output.begin(), tables.output.end(), tool.nodes[i]);
    if (at == tables.output.end() || *at != tool.nodes[i]) continue;
    auto row = linear.unit_responses.row(at - tables.output.begin());
    row.setZero();
    for (int axis = 0; axis < 3; ++axis) row[4 * axis] = tool.weights[i];
  }
  result.model = describe_node(tables, node, point, tool, rays);
  result.model.linear = std::move(linear);
  return result;
}

}  // namespace phynness
