// Selection of the centers of the amplitudes, of the shape of their kernel, and of the centers of a force.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "dense_products.hpp"
#include "dense_solvers.hpp"
#include "left_out.hpp"
#include "modal_parts.hpp"

namespace phynness {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Number of products of two components of a displacement.
constexpr int n_even = 6;

/// Error of the amplitudes at left-out directions: mean over the states of the root mean square over nodes, over the
/// largest displacement of a node. (Modes are orthonormal, so that the norm of the amplitudes is that of the field.)
double left_out_error(const TrainingTables& tables, const NodeModes& node, double shape) {
  // Close neighbours along a direction would make the matrix numerically singular.
  std::vector<Index> kept;
  std::vector<std::int32_t> rows, directions;
  const auto stride = static_cast<std::ptrdiff_t>((node.row.size() + max_search_states - 1) / max_search_states);
  for (std::size_t i = 0; i < node.row.size(); ++i) {
    const auto increment = node.row[i] % tables.n_increments;
    const auto at = std::lower_bound(node.increments.begin(), node.increments.end(), increment);
    if (at == node.increments.end() || *at != increment || (node.increments.end() - 1 - at) % stride != 0) continue;
    kept.push_back(static_cast<Index>(i));
    rows.push_back(node.row[i]);
    directions.push_back(node.direction[i]);
  }
  const auto x = scaled_rows(tables, rows);
  const Index n = x.rows() + 1;
  if (n == 1) return 0;
  MatrixXd phi(n, n), tail = MatrixXd::Ones(n, 4), values = MatrixXd::Zero(n, node.amplitudes.cols());
  values.bottomRows(n - 1) = node.amplitudes(kept, Eigen::all);
  const auto place = [&](Index i) -> Vector3d {
    return i == 0 ? Vector3d::Zero() : Vector3d(x.row(i - 1).transpose());
  };
  for (Index i = 0; i < n; ++i) {
    tail.row(i).tail<3>() = place(i).transpose();
    for (Index j = 0; j < n; ++j) phi(i, j) = multiquadric(place(i) - place(j), shape);
  }
  const MatrixXd errors = left_out(phi, tail, values, groups_of_equal(directions, 1, 1));
  const double n_output = static_cast<double>(node.modes.rows()) / node.components;
  return node.largest_value > 0
             ? errors.bottomRows(n - 1).rowwise().norm().mean() / std::sqrt(n_output) / node.largest_value
             : 0;
}

/// The data of one node in the selection of centers.
struct SelectionState {
  MatrixXd columns;  ///< states x candidates, orthogonal to the linear part and to selected columns, as the residual is
  MatrixXd residual;               ///< states x modes: amplitudes that are not yet explained
  VectorXd initial_squared_norms;  ///< of the columns
};

SelectionState selection_of(const TrainingTables& tables, const NodeModes& node, const Eigen::MatrixX3d& candidates,
                            double shape) {
  SelectionState c;
  const MatrixXd f = features(scaled_rows(tables, node.row), candidates, shape);
  const MatrixXd linear = orthonormal(f.rightCols<3>());
  c.columns = f.leftCols(candidates.rows());
  c.columns -= product(linear, transposed_product(linear, c.columns));
  c.residual = node.amplitudes / std::max(node.largest_value, std::numeric_limits<double>::min());
  c.residual -= product(linear, transposed_product(linear, c.residual));
  c.initial_squared_norms = c.columns.colwise().squaredNorm();
  return c;
}

/// The squared amplitude that each candidate would explain; 0 where the remainder of a candidate is rounding.
VectorXd explained(const SelectionState& c) {
  const VectorXd left = c.columns.colwise().squaredNorm();
  const VectorXd slope = transposed_product(c.columns, c.residual).rowwise().squaredNorm();
  return (left.array() > 1e-10 * c.initial_squared_norms.array()).select(slope.array() / left.array(), 0.0);
}

void project_out(SelectionState& c, Index candidate) {
  const double size = c.columns.col(candidate).norm();
  if (!(size > 0)) return;
  const VectorXd direction = c.columns.col(candidate) / size;
  for (MatrixXd* of_columns : {&c.columns, &c.residual})
    *of_columns -= direction * transposed_applied(*of_columns, direction).transpose();
}

using Eigen::Matrix3d;

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

Eigen::MatrixX3d scaled_rows(const TrainingTables& tables, const std::vector<std::int32_t>& rows) {
  Eigen::MatrixX3d x(static_cast<Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i)
    x.row(static_cast<Index>(i)) = tables.displacements.row(rows[i]) / tables.magnitudes_m.back();
  return x;
}

MatrixXd features(const Eigen::MatrixX3d& x, const Eigen::MatrixX3d& centers, double shape, int degree) {
  const Index n_centers = centers.rows();
  const auto anchored = [shape](const Vector3d& at, const Vector3d& c) {
    return multiquadric(at - c, shape) - multiquadric(at, shape) - multiquadric(c, shape) + shape;
  };
  MatrixXd f(x.rows(), n_centers + 3 + (degree > 0 ? n_even : 0));
  for (Index i = 0; i < x.rows(); ++i)
    for (Index j = 0; j < n_centers; ++j) f(i, j) = anchored(x.row(i).transpose(), centers.row(j).transpose());
  f.middleCols<3>(n_centers) = x;
  if (degree > 0)
    for (Index i = 0; i < x.rows(); ++i)
      f.row(i).tail<n_even>() = even_features(x.row(i).transpose(), degree).transpose();
  return f;
}

Eigen::Matrix<double, 6, 1> even_features(const Vector3d& x, int degree) {
  const double size = x.norm();
  if (!(size > 0)) return Eigen::Matrix<double, 6, 1>::Zero();
  const double by = degree == 1 ? size : 1;
  Eigen::Matrix<double, 6, 1> e;
  e << x[0] * x[0], x[0] * x[1], x[0] * x[2], x[1] * x[1], x[1] * x[2], x[2] * x[2];
  return e / by;
}

AmplitudeCenters choose_amplitude_centers(const TrainingTables& tables, const std::vector<NodeModes>& nodes,
                                          int max_centers) {
  AmplitudeCenters chosen;
  if (std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.row.empty(); })) return chosen;
  chosen.left_out_error = std::numeric_limits<double>::infinity();
  for (const double candidate : shape_candidates) {
    // The median is used because a node where the body snaps through is not predicted by any shape and would dominate a
    // mean.
    std::vector<double> errors;
    for (const auto& node : nodes) errors.push_back(left_out_error(tables, node, candidate));
    std::sort(errors.begin(), errors.end());
    const double error = errors[(errors.size() - 1) / 2];
    if (error < chosen.left_out_error) {
      chosen.left_out_error = error;
      chosen.shape = candidate;
    }
  }
  std::set<std::int32_t> every;
  for (const auto& node : nodes) every.insert(node.row.begin(), node.row.end());
  // Candidates are the states of all nodes, because nodes with different normals have different states.
  const std::vector<std::int32_t> rows(every.begin(), every.end());
  const auto x = scaled_rows(tables, rows);
  std::vector<SelectionState> selections;
  for (const auto& node : nodes)
    if (!node.row.empty()) selections.push_back(selection_of(tables, node, x, chosen.shape));
  std::vector<char> open(rows.size(), 1);
  while (!rows.empty() && static_cast<int>(chosen.row.size()) < max_centers) {
    VectorXd sum = VectorXd::Zero(x.rows());
    for (const auto& c : selections) sum += explained(c);
    for (Index i = 0; i < x.rows(); ++i)
      if (!open[static_cast<std::size_t>(i)]) sum[i] = 0;
    Index best = 0;
    if (!(sum.maxCoeff(&best) > 0)) break;
    open[static_cast<std::size_t>(best)] = 0;
    chosen.row.push_back(rows[static_cast<std::size_t>(best)]);
    for (auto& c : selections) project_out(c, best);
  }
  chosen.order = chosen.row;
  std::sort(chosen.row.begin(), chosen.row.end());
  return chosen;
}

std::vector<Index> choose_centers(Columns columns, VectorXd rest, int wanted) {
  const MatrixXd q = orthonormal(columns.stiffness);
  MatrixXd& w = columns.centers;
  subtract_product(w, q, transposed_product(q, w));
  rest -= applied(q, transposed_applied(q, rest));
  const Index n = w.cols() / 3;
  std::vector<Matrix3d> gram;
  VectorXd slope = transposed_applied(w, rest), first(n);
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
    const MatrixXd along = transposed_product(direction, w);
    subtract_product(w, direction, along);
    const VectorXd step = transposed_applied(direction, rest);
    rest -= applied(direction, step);
    slope -= transposed_applied(along, step);
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
