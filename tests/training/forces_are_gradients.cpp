// Claim: the force network of a modal model reproduces a conservative force with at most the requested number of
// centers, and is the gradient of a potential for any training data.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <phynness/training/conservative_fit.hpp>
#include <random>

#include "left_out.hpp"
#include "small_responses.hpp"

namespace phynness::test {
namespace {

constexpr double depth = 0.012;  // of small_header()

/// States at all displacements of small_header(), x = d / depth.
ForceStates states_of(const TrainingTables& tables,
                      const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& force) {
  ForceStates states;
  const auto n = tables.displacements.rows();
  states.x = tables.displacements / depth;
  states.force.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    states.force.row(i) = force(states.x.row(i).transpose());
    states.row.push_back(static_cast<std::int32_t>(i));
    states.direction.push_back(static_cast<std::int32_t>(i) / tables.n_increments);
  }
  return states;
}

/// Gradient of x.Ax/2 + 0.3 sin(x_0 + 2 x_1) + 0.1 |x|^4: smooth, stiffer when pushed far, not symmetric in
/// any axis.
Eigen::Vector3d smooth_force(const Eigen::Vector3d& x) {
  const Eigen::Vector3d linear(2 * x[0] + 0.3 * x[1], 0.3 * x[0] + 1.5 * x[1], x[2]);
  return linear + 0.3 * std::cos(x[0] + 2 * x[1]) * Eigen::Vector3d(1, 2, 0) - Eigen::Vector3d(0.3, 0.6, 0) +
         0.4 * x.squaredNorm() * x;
}

TEST(ConservativeFit, RepeatsAConservativeForceBetweenTheDirections) {
  const auto tables = training_tables(small_header());
  const auto fit = fit_conservative(states_of(tables, smooth_force), depth, 80);
  EXPECT_LE(fit.network.centers.size(), 80u);
  double error = 0, largest = 0;
  for (int i = 0; i < 200; ++i) {
    const double z = 1 - (i + 0.5) / 100, ring = std::sqrt(1 - z * z), size = 0.2 + 0.8 * (i % 7) / 6;
    const Eigen::Vector3d x = size * Eigen::Vector3d(ring * std::cos(2.4 * i), ring * std::sin(2.4 * i), z);
    const auto expected = smooth_force(x);
    error += (evaluate_force(fit.network, tables.displacements, depth, x) - expected).norm() / 200;
    largest = std::max(largest, expected.norm());
  }
  // 26 directions 35 to 55 degrees apart; half a percent is a tenth of what the nearest direction's force
  // would miss by.
  EXPECT_LT(error / largest, 5e-3);
}

// Claim: where increments are few, the energies of the states reduce the error between them. A third less, because
// energies add one equation to the three of a force; the two fits differ in nothing else.
TEST(ConservativeFit, LearnsFromEnergies) {
  const auto tables = training_tables(small_header());
  const auto all = states_of(tables, smooth_force);
  ForceStates some;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = tables.n_increments / 2 - 1; i < all.x.rows(); i += tables.n_increments / 2) kept.push_back(i);
  some.x = all.x(kept, Eigen::all);
  some.force = all.force(kept, Eigen::all);
  for (const auto i : kept) {
    some.row.push_back(all.row[static_cast<std::size_t>(i)]);
    some.direction.push_back(all.direction[static_cast<std::size_t>(i)]);
  }
  ForceStates with = some;
  with.energy.resize(some.x.rows());
  for (Eigen::Index i = 0; i < some.x.rows(); ++i) {
    const Eigen::Vector3d x = some.x.row(i);
    with.energy[i] = x[0] * x[0] + 0.3 * x[0] * x[1] + 0.75 * x[1] * x[1] + x[2] * x[2] / 2 +
                     0.3 * std::sin(x[0] + 2 * x[1]) - 0.3 * x[0] - 0.6 * x[1] + 0.1 * std::pow(x.squaredNorm(), 2);
  }
  const auto error = [&](const ForceStates& states) {
    const auto fit = fit_conservative(states, depth, 80);
    double sum = 0;
    for (Eigen::Index i = 0; i < all.x.rows(); ++i)
      sum += (evaluate_force(fit.network, tables.displacements, depth, all.x.row(i).transpose()) -
              all.force.row(i).transpose())
                 .norm();
    return sum;
  };
  EXPECT_LT(error(with), 0.67 * error(some));
}

TEST(ConservativeFit, TakesAsManyCentersAsTheStatesAreFor) {
  const auto tables = training_tables(small_header());
  const auto states = states_of(tables, smooth_force);
  auto noisy = states;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.1);  // a thirtieth of the largest force
  for (Eigen::Index i = 0; i < noisy.force.size(); ++i) noisy.force(i) += noise(random);
  EXPECT_EQ(fit_conservative(states, depth, 30).network.centers.size(), 30u);
  EXPECT_LT(fit_conservative(noisy, depth, 30).network.centers.size(), 15u);
}

TEST(ConservativeFit, NeverPushesTheToolAwayFarBeyondTheData) {
  // A force that softens until it drops: least squares alone would continue the drop.
  const auto tables = training_tables(small_header());
  const auto softening = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return x * (3 * std::exp(-1.5 * x.squaredNorm()) + 0.2);
  };
  const auto fit = fit_conservative(states_of(tables, softening), depth, 80);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(fit.network.stiffness).eigenvalues()[0], 0);
  for (const double size : {20.0, 100.0, 1e4})
    for (int k = 0; k < 26; ++k) {
      const Eigen::Vector3d e = tables.displacements.row(4 * k).transpose().normalized();
      EXPECT_GT(evaluate_force(fit.network, tables.displacements, depth, size * e).dot(e), 0) << size << " R";
    }
}

TEST(ConservativeFit, OfALinearBodyIsItsStiffness) {
  const auto tables = training_tables(small_header());
  Eigen::Matrix3d stiffness;
  stiffness << 40, 5, -3, 5, 25, 2, -3, 2, 60;
  const auto fit = fit_conservative(
      states_of(tables, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return stiffness * depth * x; }), depth, 80);
  EXPECT_LT((fit.network.stiffness - stiffness).norm(), 1e-6 * stiffness.norm());  // floats
  const Eigen::Vector3d far(30, -20, 10);
  const Eigen::Vector3d expected = stiffness * depth * far;
  EXPECT_LT((evaluate_force(fit.network, tables.displacements, depth, far) - expected).norm(), 1e-5 * expected.norm());
}

TEST(ConservativeFit, SurvivesStatesThatSayLittle) {
  const auto tables = training_tables(small_header());
  const auto all = states_of(tables, smooth_force);
  for (const Eigen::Index n : {1, 2, 5, 9}) {
    ForceStates some{all.x.topRows(n),
                     all.force.topRows(n),
                     {all.row.begin(), all.row.begin() + n},
                     {all.direction.begin(), all.direction.begin() + n}};
    const auto fit = fit_conservative(some, depth, 80);
    EXPECT_LE(2 * fit.network.centers.size(), static_cast<std::size_t>(n));
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector3d expected = some.force.row(i);
      const auto said = evaluate_force(fit.network, tables.displacements, depth, some.x.row(i).transpose());
      EXPECT_LT((said - expected).norm(), 0.25 * expected.norm()) << n << " states";  // nothing would be 1
    }
  }
  ForceStates still = all;
  still.force.setZero();
  const auto fit = fit_conservative(still, depth, 80);
  EXPECT_EQ(evaluate_force(fit.network, tables.displacements, depth, {0.3, 0.2, 0.1}).norm(), 0);
}

// Claim: errors at groups left out are those of solving again without them.
TEST(LeftOut, EqualsSolvingAgain) {
  const int n = 20;
  Eigen::MatrixXd kernel(n, n), tail = Eigen::MatrixXd::Ones(n, 2), values(n, 1);
  for (int i = 0; i < n; ++i) {
    const double x = 0.37 * i + 0.1 * std::sin(7.0 * i);
    tail(i, 1) = x;
    values(i, 0) = std::sin(x);
    for (int j = 0; j < n; ++j) {
      const double y = 0.37 * j + 0.1 * std::sin(7.0 * j);
      kernel(i, j) = std::pow(std::abs(x - y), 3);
    }
  }
  const std::vector<std::int32_t> direction{0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3};
  const auto groups = groups_of_equal(direction, 1, 0);
  const auto errors = left_out(kernel, tail, values, groups);
  for (const auto& group : groups) {
    std::vector<Eigen::Index> rest;
    for (int i = 0; i < n; ++i)
      if (std::find(group.begin(), group.end(), i) == group.end()) rest.push_back(i);
    const auto m = static_cast<Eigen::Index>(rest.size());
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(m + 2, m + 2), right = Eigen::MatrixXd::Zero(m + 2, 1);
    system.topLeftCorner(m, m) = kernel(rest, rest);
    system.topRightCorner(m, 2) = tail(rest, Eigen::all);
    system.bottomLeftCorner(2, m) = tail(rest, Eigen::all).transpose();
    right.topRows(m) = values(rest, Eigen::all);
    const Eigen::MatrixXd w = system.fullPivLu().solve(right);
    for (const auto i : group) {
      double said = tail.row(i).dot(w.bottomRows(2).col(0));
      for (Eigen::Index j = 0; j < m; ++j) said += kernel(i, rest[static_cast<std::size_t>(j)]) * w(j, 0);
      EXPECT_NEAR(errors(i, 0), values(i, 0) - said, 1e-8);  // condition of the system about 1e6
    }
  }
}

}  // namespace
}  // namespace phynness::test
