// Claim: the multifrontal LDL^T solves as dense algebra does and counts the negative eigenvalues, for graphs of any
// size and shape; it reports a matrix that it cannot factorize, and factorizes the next one.
//
// Diagonals are 2 to 8 times the largest sum of moduli beside the diagonal of any row. The condition number in the
// maximum norm is therefore at most 9, and no pivot vanishes. Rounding leaves 9 x 1e-16 times at most the number of
// rows, 600; 1e-12 is twice that.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "solve/multifrontal.hpp"

namespace phynness::test {
namespace {

/// Blocks of unknowns with the same pattern at the vertices of a graph, in random order.
struct Sparse {
  Eigen::MatrixXd dense;
  std::vector<std::int32_t> row_start{0}, column;
  std::vector<double> values;

  Sparse(std::mt19937& random, int nodes, int neighbours, int span) {
    std::vector<int> node;
    for (int i = 0; i < nodes; ++i) node.insert(node.end(), 1 + static_cast<int>(random() % 4), i);
    std::shuffle(node.begin(), node.end(), random);
    Eigen::MatrixXi joined = Eigen::MatrixXi::Identity(nodes, nodes);
    for (int i = 0; i < nodes; ++i)
      for (int k = 0; k < neighbours; ++k) {
        const int j = (i + static_cast<int>(random() % static_cast<unsigned>(span))) % nodes;
        joined(i, j) = joined(j, i) = 1;
      }
    const auto n = static_cast<Eigen::Index>(node.size());
    std::uniform_real_distribution<double> value(-1, 1);
    dense = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < i; ++j)
        if (joined(node[i], node[j])) dense(i, j) = dense(j, i) = value(random);
    const double scale = dense.cwiseAbs().rowwise().sum().maxCoeff() + 1;
    for (Eigen::Index i = 0; i < n; ++i) dense(i, i) = (random() % 3 ? 1 : -1) * scale * (5 + 3 * value(random));
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j)
        if (joined(node[i], node[j])) column.push_back(static_cast<int>(j));
      row_start.push_back(static_cast<int>(column.size()));
    }
    copy_values();
  }
  void copy_values() {
    values.clear();
    for (std::size_t i = 0; i + 1 < row_start.size(); ++i)
      for (auto k = row_start[i]; k < row_start[i + 1]; ++k)
        values.push_back(dense(static_cast<Eigen::Index>(i), column[k]));
  }
};

void expect_dense_answer(Multifrontal& factors, const Sparse& matrix) {
  ASSERT_TRUE(factors.factorize(matrix.values));
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(matrix.dense.rows(), -1, 2);
  Eigen::VectorXd x = b;
  const std::span<double> in_place(x.data(), static_cast<std::size_t>(x.size()));
  factors.solve(in_place, in_place);
  const Eigen::VectorXd expected = matrix.dense.fullPivLu().solve(b);
  EXPECT_LE((x - expected).lpNorm<Eigen::Infinity>(), 1e-12 * expected.lpNorm<Eigen::Infinity>());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix.dense, Eigen::EigenvaluesOnly);
  EXPECT_EQ(factors.negative_pivots(), (eigen.eigenvalues().array() < 0).count());
}

TEST(Multifrontal, SolvesAndCountsAsDenseAlgebraDoes) {
  std::mt19937 random(7);
  // Single nodes, graphs without edges, bands, sparse and full graphs: one front and many levels of fronts.
  for (const int nodes : {1, 2, 3, 5, 17, 60, 150})
    for (const int neighbours : {0, 1, 3, nodes})
      for (const int span : {1, 4, nodes}) {
        SCOPED_TRACE(std::to_string(nodes) + " nodes, " + std::to_string(neighbours) + " neighbours within " +
                     std::to_string(span));
        const Sparse matrix(random, nodes, neighbours, span);
        Multifrontal factors(matrix.row_start, matrix.column);
        expect_dense_answer(factors, matrix);
      }
}

TEST(Multifrontal, SaysWhatHasNoFactorsAndFactorizesTheNext) {
  std::mt19937 random(8);
  Sparse matrix(random, 60, 3, 60);
  Multifrontal factors(matrix.row_start, matrix.column);
  const Eigen::MatrixXd good = matrix.dense;
  for (const double wrong : {0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const Eigen::Index row : {Eigen::Index{0}, good.rows() / 2, good.rows() - 1}) {
      matrix.dense.row(row).setZero();
      matrix.dense.col(row).setZero();
      matrix.dense(row, row) = wrong;
      matrix.copy_values();
      EXPECT_FALSE(factors.factorize(matrix.values)) << "row " << row << " is " << wrong;
      matrix.dense = good;
      matrix.copy_values();
      expect_dense_answer(factors, matrix);
    }
}

}  // namespace
}  // namespace phynness::test
