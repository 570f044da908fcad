#include "parts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "threads.hpp"

namespace phynness::reduced {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The chosen points with their equations and weights.
class Chosen {
 public:
  Chosen(const Eigen::MatrixXf& parts, const VectorXd& wanted) : _parts(parts), _wanted(wanted), _left(wanted) {}

  Index size() const { return static_cast<Index>(_points.size()); }
  const std::vector<std::int32_t>& points() const { return _points; }
  const VectorXd& weights() const { return _weights; }
  /// wanted - parts weights
  const VectorXd& left() const { return _left; }

  /// Adds a point, and removes those whose weights would not be positive.
  void add(std::int32_t point) {
    const Index n = size();
    _points.push_back(point);
    _columns.conservativeResize(_parts.rows(), n + 1);
    _columns.col(n) = _parts.col(point).cast<double>();
    _gram.conservativeResize(n + 1, n + 1);
    _gram.col(n) = _columns.transpose() * _columns.col(n);
    _gram.row(n) = _gram.col(n).transpose();
    _right.conservativeResize(n + 1);
    _right[n] = _columns.col(n).dot(_wanted);
    _weights.conservativeResize(n + 1);
    _weights[n] = 0;
    for (;;) {
      MatrixXd gram = _gram;
      gram.diagonal().array() += 1e-12 * _gram.trace() / static_cast<double>(size());
      const VectorXd solved = gram.llt().solve(_right);
      double step = 1;
      Index last = -1;
      for (Index i = 0; i < size(); ++i) {
        if (solved[i] > 0) continue;
        const double to_zero = _weights[i] / std::max(_weights[i] - solved[i], 1e-300);
        if (last < 0 || to_zero < step) step = to_zero, last = i;
      }
      _weights += step * (solved - _weights);
      if (last < 0) break;
      remove(last);
    }
    _left = _wanted - _columns * _weights;
  }

 private:
  void remove(Index i) {
    const Index behind = size() - 1 - i;
    const auto shortened = [&](auto& list) {
      list.segment(i, behind) = list.tail(behind).eval();
      list.conservativeResize(list.size() - 1);
    };
    _points.erase(_points.begin() + i);
    _columns.middleCols(i, behind) = _columns.rightCols(behind).eval();
    _columns.conservativeResize(Eigen::NoChange, size());
    _gram.middleCols(i, behind) = _gram.rightCols(behind).eval();
    _gram.middleRows(i, behind) = _gram.bottomRows(behind).eval();
    _gram.conservativeResize(size(), size());
    shortened(_right);
    shortened(_weights);
  }

  const Eigen::MatrixXf& _parts;
  const VectorXd& _wanted;
  std::vector<std::int32_t> _points;
  MatrixXd _columns, _gram;
  VectorXd _right, _weights, _left;
};

}  // namespace

Cubature nonnegative_weights(const Eigen::MatrixXf& parts, const VectorXd& wanted, Index count, int threads,
                             const std::function<void(Index)>& told) {
  constexpr Index block = 256;
  const Index n = parts.cols();
  Chosen chosen(parts, wanted);
  std::vector<char> refused(static_cast<std::size_t>(n), 0);  // those without a weight by rounding
  Eigen::VectorXf gain(n);
  while (chosen.size() < count) {
    const Eigen::VectorXf left = chosen.left().cast<float>();
    for_each_index(static_cast<std::int32_t>((n + block - 1) / block), threads, [&](std::int32_t job) {
      const Index from = job * block, size = std::min(block, n - from);
      gain.segment(from, size).noalias() = parts.middleCols(from, size).transpose() * left;
    });
    for (Index i = 0; i < n; ++i)
      if (refused[static_cast<std::size_t>(i)]) gain[i] = 0;
    for (const auto point : chosen.points()) gain[point] = 0;
    Index best = 0;
    if (!(gain.maxCoeff(&best) > 0)) break;
    const auto point = static_cast<std::int32_t>(best);
    chosen.add(point);
    refused[static_cast<std::size_t>(best)] = std::ranges::find(chosen.points(), point) == chosen.points().end();
    told(chosen.size());
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
  out.left = chosen.left();
  return out;
}

}  // namespace phynness::reduced
