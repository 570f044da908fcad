#include "parts.hpp"

#include <algorithm>
#include <utility>

#include "dense_products.hpp"
#include "dense_solvers.hpp"
#include "sampling.hpp"
#include "threads.hpp"

namespace phynness::reduced {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index spare_columns = 10;
constexpr int power_iterations = 3;
/// Eigenvalues of a Gram matrix below this part of the largest are rounding.
constexpr double rounding = 1e-13;
constexpr Index rows_of_a_job = 256;  ///< of products on several threads

/// a * b by blocks of rows, of a^T * b by blocks of columns of a.
MatrixXd parallel_product(const MatrixXd& a, bool transposed, const MatrixXd& b, int threads) {
  const Index n = transposed ? a.cols() : a.rows();
  MatrixXd out(n, b.cols());
  for_each_index(static_cast<std::int32_t>((n + rows_of_a_job - 1) / rows_of_a_job), threads, [&](std::int32_t job) {
    const Index from = job * rows_of_a_job, rows = std::min(rows_of_a_job, n - from);
    out.middleRows(from, rows) =
        transposed ? transposed_product(a.middleCols(from, rows), b) : product(a.middleRows(from, rows), b);
  });
  return out;
}

}  // namespace

MatrixXd side_by_side(std::vector<MatrixXd> matrices, Index rows) {
  Index n = 0;
  for (const auto& m : matrices) n += m.cols();
  MatrixXd all(rows, n);
  n = 0;
  for (auto& m : matrices) {
    all.middleCols(n, m.cols()) = m;
    n += std::exchange(m, {}).cols();  // frees its memory
  }
  return all;
}

MatrixXd orthonormal_in(const Metric& metric, MatrixXd columns) {
  for (int round = 0; round < 2; ++round) {  // the second removes what rounding leaves in the first
    const auto eigen = symmetric_eigen(transposed_product(columns, metric(columns)));
    const Index n = eigen.values.size();
    Index kept = 0;
    while (kept < n && eigen.values[n - 1 - kept] > rounding * eigen.values[n - 1]) ++kept;
    const auto lengths = eigen.values.tail(kept).cwiseSqrt();
    columns = product(columns, eigen.vectors.rightCols(kept) * lengths.cwiseInverse().asDiagonal());
  }
  return columns;
}

MatrixXd scaled_modes(const Metric& metric, const MatrixXd& columns, double lost, double& energy) {
  const auto eigen = symmetric_eigen(transposed_product(columns, metric(columns)));
  energy = eigen.values.sum();
  Index left_out = 0;
  for (double rest = 0; left_out < eigen.values.size(); ++left_out)
    if ((rest += eigen.values[left_out]) > lost * energy) break;
  return product(columns, eigen.vectors.rightCols(eigen.values.size() - left_out));
}

MatrixXd leading_modes(const Metric& metric, const MatrixXd& columns, Index count, std::uint64_t seed, int threads,
                       double& captured) {
  SplitMix64 random(seed);
  MatrixXd inner(columns.cols(), std::min(count + spare_columns, columns.cols()));
  for (Index i = 0; i < inner.size(); ++i) inner.data()[i] = static_cast<double>(random.next() >> 11) * 0x1p-53 - 0.5;
  MatrixXd basis;
  for (int round = 0; round <= power_iterations; ++round) {
    if (round > 0) inner = orthonormal(inner);
    basis = orthonormal_in(metric, parallel_product(columns, false, inner, threads));
    inner = parallel_product(columns, true, metric(basis), threads);
  }
  const auto eigen = symmetric_eigen(transposed_product(inner, inner));
  const Index kept = std::min(count, eigen.values.size());
  captured = eigen.values.tail(kept).sum();
  return product(basis, eigen.vectors.rightCols(kept).rowwise().reverse());
}

}  // namespace phynness::reduced
