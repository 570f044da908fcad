// Claim: a level is identical to the result of a training with its number of centers, neurons or modes, so that each is
// the least squares fit of its size. The full level is identical to the result of a training without levels.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <phynness/training/conservative_fit.hpp>
#include <phynness/training/network_fit.hpp>
#include <random>

#include "left_out.hpp"
#include "levels.hpp"
#include "small_responses.hpp"

namespace phynness::test {
namespace {

constexpr double trained_depth = 0.012;  // of small_header()

TrainingSpec spec_of(Family family, int levels) {
  TrainingSpec spec = family == Family::modal ? modal_spec() : small_spec();
  spec.force_centers = 40;
  spec.amplitude_centers = 40;
  spec.levels = levels;
  return spec;
}

Model trained(const TrainingSpec& spec) {
  const auto header = small_header(8);
  TrainingReport report;
  return train(source_of(header), spec, report, {}, 2);
}

class Levels : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Levels, testing::Values(Family::rbfn, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Levels, HalveTheSizeAndLeaveTheFullOneAsItIs) {
  Model model = trained(spec_of(GetParam(), 3));
  ASSERT_EQ(model.levels.size(), 3u);
  for (const auto& node : model.nodes) {
    ASSERT_EQ(node.levels.size(), 2u);
    for (int l = 0; l < 2; ++l) {
      const auto& level = node.levels[static_cast<std::size_t>(l)];
      const auto half = [&](Eigen::Index full, int least) {
        return static_cast<Eigen::Index>(level_size(static_cast<int>(full), 2 - l, least));
      };
      if (GetParam() == Family::rbfn) {
        EXPECT_EQ(level.force.weights.rows(), half(node.force.weights.rows(), least_neurons));
        EXPECT_EQ(level.deformation.weights.rows(), half(node.deformation.weights.rows(), least_neurons));
      } else {
        EXPECT_EQ(level.conservative.coefficients.rows(),
                  half(node.conservative.coefficients.rows(), least_force_centers));
        EXPECT_EQ(level.weights.cols(), half(node.modal.weights.cols(), least_modes));
      }
    }
  }
  const auto again = read_model_text(write_model_text(model), "text");
  EXPECT_EQ(write_model_text(again), write_model_text(model));
  model.levels.clear();
  for (auto& node : model.nodes) node.levels.clear();
  EXPECT_EQ(write_model_text(model), write_model_text(trained(spec_of(GetParam(), 1))));
}

TEST(LevelSizes, HaveALeast) {
  EXPECT_EQ(level_size(78, 1, 4), 39);
  EXPECT_EQ(level_size(78, 2, 4), 20);
  EXPECT_EQ(level_size(78, 7, 4), 4);
  EXPECT_EQ(level_size(3, 2, 4), 3);
  EXPECT_EQ(level_size(0, 2, 4), 0);
}

// Greedy choices do not know how many will follow.
TEST(LevelsOfForces, AreTrainingsOfTheirSize) {
  const auto header = small_header();
  const auto tables = training_tables(header);
  for (const std::int32_t active : {0, 5, 9}) {
    const auto states = force_states(tables, small_rays(header, active));
    const auto fit = fit_conservative(states, trained_depth, 40, 4);
    ASSERT_EQ(fit.levels.size(), 4u);
    for (const auto& level : fit.levels) {
      const auto alone = fit_conservative(states, trained_depth, static_cast<int>(level.network.centers.size()));
      EXPECT_EQ(level.network.centers, alone.network.centers);
      EXPECT_EQ(level.network.coefficients, alone.network.coefficients);
      EXPECT_EQ(level.network.stiffness, alone.network.stiffness);
      EXPECT_EQ(level.network.shape, alone.network.shape);
    }
    EXPECT_EQ(fit.levels.back().network.coefficients, fit.network.coefficients);
  }
}

TEST(LevelsOfNetworks, AreTrainingsOfTheirSize) {
  const auto header = small_header();
  const auto tables = training_tables(header);
  const auto points = deformation_points(tables, small_rays(header, 3), {{9}, {1}}, 9, 800, 1);
  const auto fit = fit_network(points, {40, 0.75, 0, 3});
  ASSERT_EQ(fit.levels.size(), 3u);
  for (const auto& level : fit.levels) {
    const auto alone = fit_network(points, {static_cast<int>(level.neurons.weights.rows()), 0.75, 0}).network;
    EXPECT_EQ(level.neurons.weights, alone.weights);
    EXPECT_EQ(level.neurons.bias, alone.bias);
    EXPECT_EQ(Eigen::MatrixXd(fit.network.centers.topRows(alone.centers.rows())), alone.centers);
  }
}

// Weights are 16-bit integers: a solution of the same equations in another order of sums may round one apart.
TEST(LevelsOfAmplitudes, AreTrainingsOfTheirSize) {
  const Model model = trained(spec_of(Family::modal, 3));
  for (std::size_t l = 0; l < 2; ++l) {
    TrainingSpec spec = spec_of(Family::modal, 1);
    spec.amplitude_centers = static_cast<int>(model.levels[l].centers.size());
    const Model alone = trained(spec);  // of all modes, of which the level has the first
    EXPECT_EQ(model.levels[l].centers, alone.shared.centers);
    EXPECT_EQ(model.shared.shape, alone.shared.shape);
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      const auto& weights = model.nodes[i].levels[l].weights;
      const auto& expected = alone.nodes[i].modal.weights;
      EXPECT_LE((weights.entries - expected.entries.leftCols(weights.cols())).cwiseAbs().maxCoeff(), 1);
      for (Eigen::Index c = 0; c < weights.cols(); ++c)
        EXPECT_NEAR(weights.scale[c], expected.scale[c], 1e-9 * expected.scale[c]);
    }
  }
}

// Claim: the errors at groups left out, from one factorization, are those of fits that never saw the group.
TEST(LeftOutOfFit, IsAFitWithoutTheGroup) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::Index n = 40, m = 9;
  Eigen::MatrixXd a(n, m), b(n, 2);
  for (auto& x : a.reshaped()) x = normal(random);
  for (auto& x : b.reshaped()) x = normal(random);
  a.col(8).setZero();
  a(3, 8) = a(4, 8) = 1;  // told by one group alone
  const double damping = 0.1;
  RowGroups groups{{0, 1, 2}, {5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}, {20}};
  Eigen::MatrixXd damped = Eigen::MatrixXd::Zero(n + m, m);
  damped.topRows(n) = a;
  damped.bottomRows(m).diagonal().setConstant(damping);
  const auto solve = [&](const Eigen::MatrixXd& rows, const Eigen::MatrixXd& right) -> Eigen::MatrixXd {
    return (rows.transpose() * rows + damping * damping * Eigen::MatrixXd::Identity(m, m))
        .llt()
        .solve(rows.transpose() * right);
  };
  const Eigen::MatrixXd errors = left_out_of_fit(damped, b - a * solve(a, b), b, groups);
  for (const auto& group : groups) {
    Eigen::MatrixXd some = a, right = b;
    for (const auto i : group) {
      some.row(i).setZero();
      right.row(i).setZero();
    }
    const Eigen::MatrixXd expected = b - a * solve(some, right);
    for (const auto i : group) EXPECT_LT((errors.row(i) - expected.row(i)).norm(), 1e-10);
  }
  // Without damping the group that alone tells a column determines it: its values count.
  const Eigen::MatrixXd undamped = left_out_of_fit(a, b, b, {{3, 4}});
  EXPECT_EQ(undamped.row(3), b.row(3));
  EXPECT_EQ(undamped.row(4), b.row(4));
}

/// Mean error of a level's force at 300 displacements that are none of the training's, over the largest force.
double true_force_error(const Model& model, const ActiveNodeModel& node, std::size_t l, std::int32_t active) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double sum = 0, largest = 0;
  for (int i = 0; i < 300; ++i) {
    Eigen::Vector3d e(uniform(random), uniform(random), uniform(random));
    e.normalize();
    const Eigen::Vector3d d = trained_depth * (uniform(random) + 1) / 2 * e;
    const Eigen::Vector3d expected = (30 + active) * d * (1 + 2000 * d.squaredNorm() + 8 * d[2]);
    Eigen::Vector3d said;
    if (model.family == Family::modal) {
      const auto& network = l < node.levels.size() ? node.levels[l].conservative : node.conservative;
      said = evaluate_force(network, model.displacements, trained_depth, d / trained_depth);
    } else {
      RbfNetwork network = node.force;
      if (l < node.levels.size()) {
        const auto& first = node.levels[l].force;
        network.weights = first.weights;
        network.bias = first.bias;
        network.centers = Eigen::MatrixXd(node.force.centers.topRows(first.weights.rows()));
      }
      said = evaluate(network, d);
    }
    sum += (said - expected).norm();
    largest = std::max(largest, expected.norm());
  }
  return sum / 300 / largest;
}

// Claim: what training says of states left out one by one is the error elsewhere in the trained range to a
// factor of three (a state's neighbours on its ray are nearer than those of a place between the rays, a state
// at the rim is extrapolated), and falls from level to level wherever that error falls by a fifth or more: 15
// Gaussians can be no better than 8.
TEST_P(Levels, TellErrorsThatBracketTheTrueOnesAndFallWithThem) {
  const Model model = trained(spec_of(GetParam(), 3));
  double before = 0, true_before = 0;
  for (std::size_t l = 0; l < 3; ++l) {
    double error = 0;
    for (std::size_t i = 0; i < model.nodes.size(); ++i)
      error += true_force_error(model, model.nodes[i], l, static_cast<std::int32_t>(i)) /
               static_cast<double>(model.nodes.size());
    const double said = model.levels[l].error_force;
    EXPECT_GT(said, error / 3) << l;
    EXPECT_LT(said, error * 3) << l;
    if (error < 0.8 * true_before) {
      EXPECT_LT(said, before) << l;
    }
    before = said;
    true_before = error;
  }
  EXPECT_LT(model.levels.back().error_force, model.levels.front().error_force);
  EXPECT_LT(model.levels.back().error_displacement, model.levels.front().error_displacement);
}

TEST(NumberOfLevels, IsBounded) {
  TrainingSpec spec;
  spec.levels = 9;
  EXPECT_ANY_THROW(trained(spec));
  spec.levels = 0;
  EXPECT_ANY_THROW(trained(spec));
}

}  // namespace
}  // namespace phynness::test
