// Claim: the modes and amplitudes of a modal model reproduce their training fields. Errors of truncation and regression
// are separated.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>
#include <phynness/training/training.hpp>

#include "small_responses.hpp"

namespace phynness::test {
namespace {

/// So many shared modes that they lose nothing: errors are those of the node's own modes and amplitudes.
TrainingSpec all_shared_spec() {
  auto spec = modal_spec();
  spec.near_nodes = 0;
  spec.shared_modes = 3 * n_nodes;
  return spec;
}

Eigen::Map<const Eigen::VectorXd> field_of(const std::vector<Ray>& rays, Eigen::Index row) {
  const auto k = static_cast<std::size_t>(row / n_increments);
  return Eigen::VectorXd::Map(&rays[k].displacement[static_cast<std::size_t>(row % n_increments * 3 * n_nodes)],
                              3 * n_nodes);
}

/// 3 n_nodes x 3: the fields linear in x that serve all states best.
Eigen::MatrixXd linear_fields(const Model& model, const std::vector<Ray>& rays) {
  const Eigen::MatrixXd x = model.displacements / model.max_displacement_m;
  Eigen::MatrixXd u(x.rows(), 3 * n_nodes);
  for (Eigen::Index i = 0; i < x.rows(); ++i) u.row(i) = field_of(rays, i).transpose();
  return (x.transpose() * x).ldlt().solve(x.transpose() * u).transpose();
}

/// Means over active nodes, states and nodes that the probe does not move, of |prediction - data| / largest
/// |data|: of the model, and of the best linear fields, which saw all states.
struct Errors {
  double model = 0, linear = 0;
};

using States = std::function<bool(std::int32_t active, int direction, int increment)>;
bool every_state(std::int32_t, int, int) { return true; }

Errors mean_errors(const Model& model, const DatabaseHeader& header, const States& counts) {
  Errors mean;
  for (std::int32_t active = 0; active < static_cast<std::int32_t>(model.nodes.size()); ++active) {
    const auto& node = model.nodes[static_cast<std::size_t>(active)];
    const auto rays = small_rays(header, active);
    const auto linear = linear_fields(model, rays);
    Errors sum;
    double largest = 0;
    int n = 0;
    for (Eigen::Index i = 0; i < model.displacements.rows(); ++i) {
      const auto row = static_cast<int>(i);
      const Eigen::Vector3d x = model.displacements.row(i).transpose() / model.max_displacement_m;
      const auto expected = field_of(rays, i);
      const Eigen::VectorXd by_model = modal_values(model, model.shared.modes, node.modal, x) - expected,
                            by_linear = linear * x - expected;
      for (int o = 0; o < n_nodes; ++o) {
        if (o == node.node) continue;
        largest = std::max(largest, expected.segment<3>(3 * o).norm());
        if (!counts(active, row / n_increments, row % n_increments)) continue;
        sum.model += by_model.segment<3>(3 * o).norm();
        sum.linear += by_linear.segment<3>(3 * o).norm();
        ++n;
      }
    }
    const double share = 1 / (n * largest * static_cast<double>(model.nodes.size()));
    mean.model += share * sum.model;
    mean.linear += share * sum.linear;
  }
  return mean;
}

TEST(ModalTraining, RepeatsTheFieldsAndSaysHowWell) {
  const auto header = small_header(8);
  TrainingReport report;
  const Model model = train(source_of(header), modal_spec(), report);
  ASSERT_EQ(model.nodes.size(), header.sets.active.size());
  const auto mean = mean_errors(model, header, every_state);
  // What it says bounds what it does, by the triangle inequality.
  EXPECT_LE(mean.model, (report.modal.truncation + report.modal.regression) * (1 + 1e-9));
  EXPECT_GT(report.modal.truncation, 0);
}

TEST(ModalTraining, CarriesWhatLinearFieldsMiss) {
  const auto header = small_header(8);
  TrainingReport report;
  const Model model = train(source_of(header), all_shared_spec(), report);
  const auto mean = mean_errors(model, header, every_state);
  // Three modes with linear amplitudes could be the linear fields; what the others add is all but a tenth of
  // the rest (a fifteenth was measured).
  EXPECT_LT(mean.model, 0.1 * mean.linear);
}

TEST(ModalTraining, MoreModesLoseLess) {
  const auto header = small_header(8);
  double before = 1;
  for (const int modes : {3, 6, 12}) {
    auto spec = modal_spec();
    spec.modes = modes;
    spec.near_nodes = n_nodes;  // so that shared modes lose nothing
    TrainingReport report;
    train(source_of(header), spec, report);
    EXPECT_LT(report.modal.truncation, 0.7 * before) << modes << " modes";  // a smooth field's modes fall off fast
    before = report.modal.truncation;
  }
}

TEST(ModalTraining, NearNodesAndSharedModesReplaceEachOther) {
  // All nodes near: the shared modes are not needed; none near and as many shared modes as unknowns: nor are those.
  const auto header = small_header(8);
  auto all_near = modal_spec();
  all_near.near_nodes = n_nodes;
  all_near.shared_modes = 0;
  TrainingReport near, shared;
  train(source_of(header), all_near, near);
  train(source_of(header), all_shared_spec(), shared);
  // Both lose only what 12 modes lose, and 16-bit rounding: 1e-4 at most.
  EXPECT_NEAR(near.modal.truncation, shared.modal.truncation, 2e-4);
}

TEST(ModalTraining, WithoutModesThereAreForcesOnly) {
  const auto header = small_header(8);
  auto spec = modal_spec();
  spec.modes = 0;
  TrainingReport report;
  const Model model = train(source_of(header), spec, report);
  EXPECT_EQ(model.shared.modes.cols(), 0);
  EXPECT_EQ(model.nodes.front().modal.weights.cols(), 0);
  EXPECT_FALSE(model.nodes.front().conservative.centers.empty());
  EXPECT_EQ(write_model_text(read_model_text(write_model_text(model), "again")), write_model_text(model));
}

TEST(ModalTraining, FailedDirectionsAreLeftOut) {
  const auto header = small_header(8);
  const States failed = [](std::int32_t active, int direction, int increment) {
    return (direction == 3 || direction == 11 || direction == 20) && increment >= active % n_increments;
  };
  ResponseSource source = source_of(header);
  source.rays = [&](std::int32_t active) {
    auto rays = small_rays(header, active);
    for (int k = 0; k < static_cast<int>(rays.size()); ++k)
      for (int i = 0; i < n_increments; ++i) {
        if (!failed(active, k, i)) continue;
        auto& ray = rays[static_cast<std::size_t>(k)];
        ray.status[static_cast<std::size_t>(i)] = i == active % n_increments ? Status::diverged : Status::after_failure;
        // A metre: whoever trains on it is far off.
        std::fill_n(ray.displacement.begin() + 3 * n_nodes * i, 3 * n_nodes, 1.0);
      }
    return rays;
  };
  TrainingReport report;
  const Model model = train(source, all_shared_spec(), report);
  EXPECT_GT(report.n_increments_failed, 0);
  // At the states that failed, which the linear fields saw and the model did not: it knows the directions
  // around them, and misses by a quarter of what those miss at most (an eighth was measured).
  const auto mean = mean_errors(model, header, failed);
  EXPECT_LT(mean.model, 0.25 * mean.linear);
}

}  // namespace
}  // namespace phynness::test
