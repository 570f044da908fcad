#include "conservative_centers.hpp"

#include <Eigen/Dense>
#include <limits>

#include "dense_solvers.hpp"

namespace phynness {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Cost of an unknown in cross-validation. It exceeds 1 because the positions of centers are also selected from the
/// data (Friedman 1991, doi 10.1214/aos/1176347963). On the paper's liver (P1, K/mu = 200) costs of 1, 1.3, 1.6 and 1.9
/// give errors of 0.71, 0.70, 0.70 and 0.72 % inside the trained range; all centers give 0.99 %.
constexpr double unknown_cost = 1.5;

/// Generalized cross-validation: an estimate, up to a factor, of the squared error between the states.
/// @param rest        residuals of all forces
/// @param n_unknowns  number of fitted unknowns
double cross_validation(const VectorXd& rest, Index n_unknowns) {
  const double left = static_cast<double>(rest.size()) - unknown_cost * static_cast<double>(n_unknowns);
  return left > 0 ? rest.squaredNorm() / (left * left) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<Index> choose_centers(Columns columns, VectorXd rest, int wanted) {
  const MatrixXd q = orthonormal(columns.stiffness);
  MatrixXd& w = columns.centers;
  w.noalias() -= q * (q.transpose() * w);
  rest -= q * (q.transpose() * rest);
  const Index n = w.cols() / 3;
  std::vector<Matrix3d> gram;
  VectorXd slope = w.transpose() * rest, first(n);
  for (Index i = 0; i < n; ++i) {
    gram.push_back(w.middleCols<3>(3 * i).transpose() * w.middleCols<3>(3 * i));
    first[i] = gram.back().trace();
  }
  std::vector<char> open(static_cast<std::size_t>(n), 1);
  std::vector<Index> chosen;
  std::size_t enough = 0;
  double least = cross_validation(rest, columns.stiffness.cols());
  while (static_cast<int>(chosen.size()) < wanted) {
    Index best = -1;
    double most = 0;
    for (Index i = 0; i < n; ++i) {
      const auto& g = gram[static_cast<std::size_t>(i)];
      // Such a small remainder of a column is rounding.
      if (!open[static_cast<std::size_t>(i)] || !(g.trace() > 1e-10 * first[i])) continue;
      const Matrix3d safe = g + 1e-12 * g.trace() * Matrix3d::Identity();
      const Vector3d h = slope.segment<3>(3 * i);
      const double explained = h.dot(safe.ldlt().solve(h));
      if (explained > most) {
        most = explained;
        best = i;
      }
    }
    if (best < 0) break;
    chosen.push_back(best);
    open[static_cast<std::size_t>(best)] = 0;
    const MatrixXd direction = orthonormal(w.middleCols<3>(3 * best));
    const MatrixXd along = direction.transpose() * w;
    w.noalias() -= direction * along;
    const Vector3d step = direction.transpose() * rest;
    rest -= direction * step;
    slope.noalias() -= along.transpose() * step;
    for (Index i = 0; i < n; ++i)
      gram[static_cast<std::size_t>(i)] -= along.middleCols<3>(3 * i).transpose() * along.middleCols<3>(3 * i);
    const auto n_unknowns = columns.stiffness.cols() + 3 * static_cast<Index>(chosen.size());
    if (const double now = cross_validation(rest, n_unknowns); now < least) {
      least = now;
      enough = chosen.size();
    }
  }
  chosen.resize(enough);
  return chosen;
}

}  // namespace phynness
