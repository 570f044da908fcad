// Claim: the modes and amplitudes of a modal model repeat the fields they were made of; truncation and
// regression are told apart; the model does not depend on the number of threads.
#include <gtest/gtest.h>

#include <cmath>
#include <phynness/training/training.hpp>

#include "small_responses.hpp"

namespace phynness::test {
namespace {

TrainingSpec modal_spec() {
  TrainingSpec spec;
  spec.family = Family::modal;
  spec.modes = 12;
  spec.shared_modes = 40;
  spec.near_nodes = 6;
  return spec;
}

/// u at all output nodes by plain loops over the model, x = d / R.
Eigen::VectorXd field(const Model& model, const ActiveNodeModel& node, const Eigen::Vector3d& x) {
  const auto& shared = model.shared;
  const auto q = [&](const Eigen::Vector3d& y) {
    return std::sqrt(y.squaredNorm() + shared.shape * shared.shape);
  };
  Eigen::VectorXd features(static_cast<Eigen::Index>(shared.centers.size()) + 3);
  for (std::size_t i = 0; i < shared.centers.size(); ++i) {
    const Eigen::Vector3d c =
        model.displacements.row(shared.centers[i]).transpose() / model.max_displacement_m;
    features[static_cast<Eigen::Index>(i)] = q(x - c) - q(x) - q(c) + shared.shape;
  }
  features.tail<3>() = x;
  const Eigen::VectorXd a = node.modal.weights.values().transpose() * features;
  Eigen::VectorXd u = shared.modes.values() * (node.modal.mixing.values() * a);
  const Eigen::VectorXd near = node.modal.near_modes.values() * a;
  for (std::size_t i = 0; i < node.modal.near.size(); ++i)
    u.segment<3>(3 * node.modal.near[i]) = near.segment<3>(3 * static_cast<Eigen::Index>(i));
  return u;
}

/// Mean over converged states and nodes that the probe does not move of |model - data| / largest |data|.
double mean_error(const Model& model, const DatabaseHeader& header, std::size_t which) {
  const auto& node = model.nodes[which];
  std::int32_t active = 0;
  while (header.sets.active[static_cast<std::size_t>(active)] != node.node) ++active;
  double error = 0, largest = 0;
  int n = 0;
  const auto rays = small_rays(header, active);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    for (int i = 0; i < n_increments; ++i) {
      const Eigen::Vector3d x =
          model.displacements.row(static_cast<Eigen::Index>(k) * n_increments + i).transpose() /
          model.max_displacement_m;
      const auto u = field(model, node, x);
      for (int o = 0; o < n_nodes; ++o) {
        if (o == node.node) continue;
        const auto expected =
            Eigen::Vector3d::Map(&rays[k].displacement[static_cast<std::size_t>(3 * (i * n_nodes + o))]);
        error += (u.segment<3>(3 * o) - expected).norm();
        largest = std::max(largest, expected.norm());
        ++n;
      }
    }
  }
  return error / n / largest;
}

TEST(ModalTraining, RepeatsTheFieldsAndSaysHowWell) {
  const auto header = small_header();
  TrainingReport report;
  const Model model = train(source_of(header), modal_spec(), report);
  ASSERT_EQ(model.nodes.size(), header.sets.active.size());
  double mean = 0;
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    mean += mean_error(model, header, i) / static_cast<double>(model.nodes.size());
  // What it says bounds what it does, by the triangle inequality.
  EXPECT_LE(mean, (report.modal.truncation + report.modal.regression) * (1 + 1e-9));
  EXPECT_LT(mean, 0.01);
  EXPECT_GT(report.modal.truncation, 0);
  EXPECT_LE(report.modal.worst_cancellation, largest_cancellation);
}

TEST(ModalTraining, MoreModesLoseLess) {
  const auto header = small_header();
  double before = 1;
  for (const int modes : {3, 6, 12}) {
    auto spec = modal_spec();
    spec.modes = modes;
    spec.near_nodes = n_nodes;  // so that shared modes lose nothing
    TrainingReport report;
    train(source_of(header), spec, report);
    EXPECT_LT(report.modal.truncation, 0.7 * before)
        << modes << " modes";  // a smooth field's modes fall off fast
    before = report.modal.truncation;
  }
}

TEST(ModalTraining, NearNodesAndSharedModesReplaceEachOther) {
  // All nodes near: the shared modes are not needed; none near and as many shared modes as unknowns: nor are
  // those.
  const auto header = small_header();
  auto all_near = modal_spec(), all_shared = modal_spec();
  all_near.near_nodes = n_nodes;
  all_near.shared_modes = 0;
  all_shared.near_nodes = 0;
  all_shared.shared_modes = 3 * n_nodes;
  TrainingReport near, shared;
  train(source_of(header), all_near, near);
  train(source_of(header), all_shared, shared);
  // Both lose only what 12 modes lose, and 16-bit rounding: 1e-4 at most.
  EXPECT_NEAR(near.modal.truncation, shared.modal.truncation, 2e-4);
}

TEST(ModalTraining, WithoutModesThereAreForcesOnly) {
  const auto header = small_header();
  auto spec = modal_spec();
  spec.modes = 0;
  TrainingReport report;
  const Model model = train(source_of(header), spec, report);
  EXPECT_EQ(model.shared.modes.cols(), 0);
  EXPECT_EQ(model.nodes.front().modal.weights.cols(), 0);
  EXPECT_FALSE(model.nodes.front().conservative.centers.empty());
  EXPECT_EQ(write_model_text(read_model_text(write_model_text(model), "again")), write_model_text(model));
}

TEST(ModalTraining, IsTheSameOnAnyNumberOfThreads) {
  const auto header = small_header();
  TrainingReport one, three;
  EXPECT_EQ(write_model_text(train(source_of(header), modal_spec(), one, {}, 1)),
            write_model_text(train(source_of(header), modal_spec(), three, {}, 3)));
}

// Claim: a direction that is there twice says no more of shape and centers than once.
TEST(ModalTraining, DirectionsMayComeTwice) {
  const auto once = small_header();
  auto twice = once;
  twice.directions.insert(twice.directions.end(), once.directions.begin(), once.directions.end());
  TrainingReport of_once, of_twice;
  const auto expected = train(source_of(once), modal_spec(), of_once),
             model = train(source_of(twice), modal_spec(), of_twice);
  EXPECT_EQ(of_twice.modal.amplitude_shape, of_once.modal.amplitude_shape);
  EXPECT_NEAR(of_twice.modal.amplitude_left_out, of_once.modal.amplitude_left_out,
              1e-6 * of_once.modal.amplitude_left_out);  // modes of twice the states, other rounding
  EXPECT_EQ(model.shared.centers, expected.shared.centers);
}

TEST(ModalTraining, FailedDirectionsAreLeftOut) {
  const auto header = small_header();
  ResponseSource source = source_of(header);
  source.rays = [&](std::int32_t active) {
    auto rays = small_rays(header, active);
    for (const int k : {3, 11, 20})
      for (int i = active % n_increments; i < n_increments; ++i)
        rays[static_cast<std::size_t>(k)].status[static_cast<std::size_t>(i)] =
            i == active % n_increments ? Status::diverged : Status::after_failure;
    return rays;
  };
  TrainingReport report;
  const Model model = train(source, modal_spec(), report);
  EXPECT_GT(report.n_increments_failed, 0);
  double mean = 0;
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    mean += mean_error(model, header, i) / static_cast<double>(model.nodes.size());
  // Measured on all states, those that failed in training included.
  EXPECT_LT(mean, 0.03);
}

}  // namespace
}  // namespace phynness::test
