#include <gtest/gtest.h>

#include <Eigen/LU>

#include "franke_points.hpp"
#include "plain_basis.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// Spread at n points: twice the mean distance of neighbours, in inputs scaled to [-1, 1].
double spread_for(int n) { return 4 / std::sqrt(n); }

// Claim: with as many coefficients as points (the bias is one of them) the training points are reproduced.
// Rounding of weights up to about 1e4 leaves 1e-11.
TEST(Franke, PointsAreReproducedWhenAllAreCenters) {
  for (const int n : {9, 25, 81, 289}) {
    const NetworkPoints points = franke_points(n);
    const NetworkFit fit = fit_network(points, {n, spread_for(n), 0});
    EXPECT_EQ(static_cast<int>(fit.centers.size()), n - 1);
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d value = evaluate(fit.network, points.displacements.row(i).transpose());
      EXPECT_LT((value.transpose() - points.outputs.row(i)).norm(), 1e-11) << n << " points, point " << i;
    }
  }
}

// Claim: the interpolant is that of a dense solve with full pivoting on the same basis, between the points
// too. The condition number reaches 4e6 (289 points), times rounding 1e-16 and a generous 1e3.
TEST(Franke, InterpolantIsThatOfADenseSolve) {
  for (const int n : {9, 25, 81, 289}) {
    const NetworkPoints points = franke_points(n);
    const NetworkFit fit = fit_network(points, {n, spread_for(n), 0});
    RbfNetwork dense = fit.network;
    const Eigen::MatrixXd w = basis(points, fit.network).fullPivLu().solve(scaled_outputs(points, fit.network));
    dense.bias = w.row(0).transpose();
    dense.weights = w.bottomRows(w.rows() - 1);
    for (int i = 0; i <= 10; ++i) {
      const Eigen::Vector2d x(i / 10.0, 1 - i * i / 100.0);
      EXPECT_LT((evaluate(fit.network, x) - evaluate(dense, x)).norm(), 1e-7) << n << " points";
    }
  }
}

// Claim: more points approximate Franke's function better, by at least a third at each step, and the last is
// good to 1 % of the function's range: the method converges on data that nobody tuned for it.
TEST(Franke, ErrorFallsAsPointsGrow) {
  double previous = 1;
  for (const int n : {9, 25, 81, 289}) {
    const NetworkFit fit = fit_network(franke_points(n), {n, spread_for(n), 0});
    const double error =
        grid_error([&](double x, double y) { return evaluate(fit.network, Eigen::Vector2d(x, y))[0]; });
    RecordProperty("rms_error_" + std::to_string(n), std::to_string(error));
    EXPECT_LT(error, previous * 2 / 3) << n << " points";
    previous = error;
  }
  EXPECT_LT(previous, 0.0122);
}

}  // namespace
