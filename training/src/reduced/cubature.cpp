#include "parts.hpp"

#include <Eigen/Core>
#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "dense_products.hpp"
#include "dense_solvers.hpp"
#include "threads.hpp"

namespace phynness::reduced {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The chosen points with their equations and weights. The Cholesky factor of the normal equations follows each change,
/// so that a point costs squares of their number only.
class WeightedPoints {
 public:
  WeightedPoints(const Eigen::MatrixXf& contributions, const VectorXd& wanted, Index most)
      : _contributions(contributions),
        _wanted(wanted),
        _columns(contributions.rows(), most),
        _factor(most, most),
        _right(most),
        _weights(most),
        _residual(wanted) {}

  Index size() const { return static_cast<Index>(_points.size()); }
  const std::vector<std::int32_t>& points() const { return _points; }
  auto weights() const { return _weights.head(size()); }
  /// wanted - contributions weights
  const VectorXd& residual() const { return _residual; }

  /// Adds a point, and removes those whose weights would not be positive.
  void add(std::int32_t point) {
    const Index n = size();
    _columns.col(n) = _contributions.col(point).cast<double>();
    const VectorXd row = solve_lower(factor(n), transposed_applied(_columns.leftCols(n), _columns.col(n)));
    const double square = _columns.col(n).squaredNorm();
    _factor.row(n).head(n) = row.transpose();
    _factor(n, n) = std::sqrt(std::max(square - row.squaredNorm(), ridge * square));
    _right[n] = _columns.col(n).dot(_wanted);
    _weights[n] = 0;
    _points.push_back(point);
    for (;;) {
      const VectorXd solved = solve_lower_transposed(factor(size()), solve_lower(factor(size()), _right.head(size())));
      double step = 1;
      Index last = -1;
      for (Index i = 0; i < size(); ++i) {
        if (solved[i] > 0) continue;
        const double to_zero = _weights[i] / std::max(_weights[i] - solved[i], 1e-300);
        if (last < 0 || to_zero < step) step = to_zero, last = i;
      }
      _weights.head(size()) += step * (solved - weights());
      if (last < 0) break;
      remove(last);
    }
    _residual = residual_of(_wanted, _columns.leftCols(size()), weights());
  }

 private:
  /// Of the square of a column, what at least remains of it beside the others.
  static constexpr double ridge = 1e-12;

  Eigen::Block<MatrixXd> factor(Index n) { return _factor.topLeftCorner(n, n); }

  void remove(Index i) {
    const Index behind = size() - 1 - i;
    // Without row i the square of the rows behind lacks that of column i (Golub and Van Loan, Matrix
    // computations, 6.5).
    const VectorXd removed_column = _factor.col(i).segment(i + 1, behind);
    _factor.middleRows(i, behind).leftCols(i) = _factor.middleRows(i + 1, behind).leftCols(i).eval();
    MatrixXd corner = _factor.block(i + 1, i + 1, behind, behind).triangularView<Eigen::Lower>();
    add_square(corner, removed_column);
    _factor.block(i, i, behind, behind) = corner;
    _columns.middleCols(i, behind) = _columns.middleCols(i + 1, behind).eval();
    _right.segment(i, behind) = _right.segment(i + 1, behind).eval();
    _weights.segment(i, behind) = _weights.segment(i + 1, behind).eval();
    _points.erase(_points.begin() + i);
  }

  /// The factor of L L^T + x x^T in place of L, by rotations.
  static void add_square(MatrixXd& L, VectorXd x) {
    for (Index k = 0; k < x.size(); ++k) {
      Eigen::JacobiRotation<double> rotation;
      rotation.makeGivens(L(k, k), x[k], &L(k, k));
      const Index n = x.size() - k - 1;
      const VectorXd below = L.col(k).tail(n);
      L.col(k).tail(n) = rotation.c() * below - rotation.s() * x.tail(n);
      x.tail(n) = rotation.s() * below + rotation.c() * x.tail(n);
      if (L(k, k) < 0) L.col(k).tail(n + 1) *= -1;
    }
  }

  const Eigen::MatrixXf& _contributions;
  const VectorXd& _wanted;
  std::vector<std::int32_t> _points;
  MatrixXd _columns, _factor;  ///< of those, in their order; the lower triangle
  VectorXd _right, _weights, _residual;
};

}  // namespace

Cubature nonnegative_weights(const Eigen::MatrixXf& contributions, const VectorXd& wanted, Index count, int threads,
                             const std::function<void(Index)>& on_added) {
  constexpr Index block = 256;
  const Index n = contributions.cols();
  WeightedPoints chosen(contributions, wanted, std::min(count, n) + 1);
  std::vector<char> refused(static_cast<std::size_t>(n), 0);  // those without a weight by rounding
  Eigen::VectorXf gain(n);
  while (chosen.size() < count) {
    const Eigen::VectorXf residual = chosen.residual().cast<float>();
    for_each_index(static_cast<std::int32_t>((n + block - 1) / block), threads, [&](std::int32_t job) {
      const Index from = job * block, size = std::min(block, n - from);
      gain.segment(from, size).noalias() = contributions.middleCols(from, size).transpose() * residual;
    });
    for (Index i = 0; i < n; ++i)
      if (refused[static_cast<std::size_t>(i)]) gain[i] = 0;
    for (const auto point : chosen.points()) gain[point] = 0;
    Index best = 0;
    if (!(gain.maxCoeff(&best) > 0)) break;
    const auto point = static_cast<std::int32_t>(best);
    chosen.add(point);
    refused[static_cast<std::size_t>(best)] = std::ranges::find(chosen.points(), point) == chosen.points().end();
    on_added(chosen.size());
  }
  std::vector<std::size_t> order(chosen.points().size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return chosen.points()[i]; });
  Cubature out;
  out.weights.resize(chosen.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    out.points.push_back(chosen.points()[order[k]]);
    out.weights[static_cast<Index>(k)] = chosen.weights()[static_cast<Index>(order[k])];
  }
  out.residual = chosen.residual();
  return out;
}

}  // namespace phynness::reduced
