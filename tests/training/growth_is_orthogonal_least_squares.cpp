#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <phynness/training/node_training.hpp>
#include <set>

#include "franke_points.hpp"
#include "plain_basis.hpp"
#include "small_responses.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

NetworkPoints small_deformation_points() {
  const DatabaseHeader header = small_header();
  return deformation_points(training_tables(header), small_rays(header, 3), {{9}, {1.0}}, 9, 800, 1);
}

// Claim: the weights are those of linear least squares on the chosen centers (section 2.2). Householder QR
// with column pivoting of the basis, formed by plain loops, is independent. Both are backward stable; the
// condition number of this basis is below 1e5, so 1e-9 leaves four digits for rounding.
TEST(Growth, WeightsAreThoseOfDenseLeastSquares) {
  const NetworkPoints points = small_deformation_points();
  const NetworkFit fit = fit_network(points, {60, 0.75, 0});
  ASSERT_EQ(fit.network.weights.rows(), 60);
  const Eigen::MatrixXd w = basis(points, fit.network).colPivHouseholderQr().solve(scaled_outputs(points, fit.network));
  EXPECT_LT((coefficients(fit.network) - w).norm(), 1e-9 * w.norm());
}

// Claim: the recorded MSE (14) is that of the finished network; 1e-10 relative is rounding of two different
// sums.
TEST(Growth, RecordedErrorIsThatOfTheNetwork) {
  const NetworkPoints points = small_deformation_points();
  const NetworkFit fit = fit_network(points, {60, 0.75, 0});
  const Eigen::MatrixXd e =
      scaled_outputs(points, fit.network) - basis(points, fit.network) * coefficients(fit.network);
  EXPECT_NEAR(fit.mse.back(), e.squaredNorm() / (3.0 * static_cast<double>(points.size())), 1e-10 * fit.mse.back());
}

// Claim: each center is the point with the largest error of the network before it, among those not yet
// chosen. The error is recomputed here from a dense solve; ties are impossible in this data to the tolerance.
TEST(Growth, NextCenterIsTheWorstPoint) {
  const NetworkPoints points = small_deformation_points();
  const NetworkFit fit = fit_network(points, {12, 0.75, 0});
  const Eigen::MatrixXd h = basis(points, fit.network), y = scaled_outputs(points, fit.network);
  for (int k = 0; k < 12; ++k) {
    const Eigen::MatrixXd part = h.leftCols(1 + k);
    Eigen::VectorXd error = (y - part * part.householderQr().solve(y)).rowwise().squaredNorm();
    for (int i = 0; i < k; ++i) error[fit.centers[i]] = 0;
    EXPECT_GE(error[fit.centers[k]], error.maxCoeff() * (1 - 1e-9)) << "neuron " << k;
  }
}

// Claim: no point becomes a center twice, even where its error stays the largest.
TEST(Growth, NeverChoosesAPointTwice) {
  for (const double spread : {0.01, 0.75, 5.0}) {
    const NetworkFit fit = fit_network(small_deformation_points(), {300, spread, 0});
    EXPECT_EQ(std::set<std::int32_t>(fit.centers.begin(), fit.centers.end()).size(), fit.centers.size());
    EXPECT_EQ(fit.mse.size(), fit.centers.size() + 1);
  }
}

// Claim: every neuron lowers the training error, as a projection on a larger space must.
TEST(Growth, TrainingErrorNeverRises) {
  const NetworkFit fit = fit_network(small_deformation_points(), {200, 0.75, 0});
  for (std::size_t k = 1; k < fit.mse.size(); ++k) EXPECT_LE(fit.mse[k], fit.mse[k - 1]);
  EXPECT_LT(fit.mse.back(), 0.01 * fit.mse.front());
}

// Claim: growth stops with the first neuron that brings the MSE to the target, not before and not after.
TEST(Growth, StopsAtTheTarget) {
  const NetworkPoints points = small_deformation_points();
  const double target = 2 * fit_network(points, {60, 0.75, 0}).mse.back();
  const NetworkFit fit = fit_network(points, {60, 0.75, target});
  EXPECT_LE(fit.mse.back(), target);
  EXPECT_GT(fit.mse[fit.mse.size() - 2], target);
}

// Claim: inputs and outputs of the training data fill [-1, 1] in every column and leave it by no rounding
// error.
TEST(Growth, ScaledDataLiesWithinOne) {
  const NetworkPoints points = small_deformation_points();
  const NetworkFit fit = fit_network(points, {1, 0.75, 0});
  for (const Eigen::MatrixXd& scaled : {scaled_inputs(points, fit.network), scaled_outputs(points, fit.network)}) {
    EXPECT_LE(scaled.maxCoeff(), 1.0);
    EXPECT_GE(scaled.minCoeff(), -1.0);
    for (Eigen::Index k = 0; k < scaled.cols(); ++k) EXPECT_NEAR(scaled.col(k).cwiseAbs().maxCoeff(), 1.0, 1e-15);
  }
}

// Claim: a constant column (a planar set of directions, a force component that is always zero) is no division
// by zero.
TEST(Growth, ConstantColumnsAreDefined) {
  NetworkPoints points = small_deformation_points();
  points.displacements.col(2).setConstant(0.25);
  points.outputs.col(1).setConstant(-3);
  const NetworkFit fit = fit_network(points, {20, 0.75, 0});
  EXPECT_TRUE(fit.network.weights.allFinite());
  Eigen::VectorXd x(6);
  x << 0.001, 0, 0.25, 0, 0, 0.03;
  EXPECT_NEAR(evaluate(fit.network, x)[1], -3, 1e-12);
}

// Claim: whatever the spread, weights are finite and the basis that is kept has a condition number that
// double precision can afford. Each column keeps at least dependence_threshold of its length after
// orthogonalization; the condition number can exceed the inverse of that by a modest factor that grows with
// the number of columns.
TEST(Growth, ExtremeSpreadsStayFinite) {
  const NetworkPoints points = franke_points(289);
  for (double spread = 1e-3; spread < 2e3; spread *= 10) {
    const NetworkFit fit = fit_network(points, {100, spread, 0});
    ASSERT_TRUE(fit.network.weights.allFinite() && fit.network.bias.allFinite()) << "spread " << spread;
    const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(basis(points, fit.network)).singularValues();
    const double condition = s[0] / s[s.size() - 1];
    EXPECT_LT(condition, 1e4 / dependence_threshold) << "spread " << spread;
    EXPECT_TRUE(std::isfinite(fit.mse.back()));
  }
}

}  // namespace
