#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/training/conservative_fit.hpp>

#include "dense_products.hpp"
#include "dense_solvers.hpp"
#include "left_out.hpp"
#include "levels.hpp"
#include "modal_parts.hpp"

namespace phynness {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Damping of the least squares for columns scaled to unit length, needed for nearly dependent columns. With half as
/// many centers as states its effect is small: on the paper's liver (P1) errors outside of the trained range are 5.76
/// %, and 5.85 % without damping; inside they are equal. On the demo a damping of 1e-4 increases the error from 0.06 to
/// 0.08 %.
constexpr double damping = 1e-6;

/// Lower bound of the eigenvalues of K, which dominates far outside of the states, as a fraction of the smallest
/// eigenvalue of the best linear stiffness. Without a bound K had negative eigenvalues at most nodes of a liver, so
/// that a force at large displacements pushed the tool further away. Errors are the same for fractions from 0.02 to 0.5
/// (docs/decisions/modal-family.md).
constexpr double least_tail_share = 0.2;

/// With more states than this, some increments are not used as centers, because the force depends mainly on the
/// direction.
constexpr std::size_t max_fit_states = 400;

/// Forces far above this fraction of the median have weights inverse to their size. Of fractions from 0.3 to 3, the
/// smaller ones were better where a liver snaps through, and equal elsewhere.
constexpr double typical_force_share = 0.3;

/// Phi(x - c) - Phi(x) - Phi(c) + Phi(0)
Matrix3d anchored_kernel(const Vector3d& x, const Vector3d& c, double shape) {
  return force_kernel(x - c, shape) - force_kernel(x, shape) - force_kernel(c, shape) +
         force_kernel(Vector3d::Zero(), shape);
}

/// The energy whose gradient is anchored_kernel() w is e . w: q(y) y has the gradient Phi(y).
Vector3d anchored_energy(const Vector3d& x, const Vector3d& c, double shape) {
  const auto of = [shape](const Vector3d& y) -> Vector3d { return multiquadric(y, shape) * y; };
  return of(x - c) - of(x) - force_kernel(c, shape) * x + shape * x + of(c);
}

/// Force for each entry of a symmetric stiffness xx xy xz yy yz zz.
Eigen::Matrix<double, 3, 6> stiffness_columns(const Vector3d& x) {
  Eigen::Matrix<double, 3, 6> k = Eigen::Matrix<double, 3, 6>::Zero();
  k(0, 0) = k(1, 1) = k(2, 2) = x[0];
  k(0, 1) = k(1, 3) = k(2, 4) = x[1];
  k(0, 2) = k(1, 4) = k(2, 5) = x[2];
  return k;
}

Columns columns_of(const ForceStates& states, double shape) {
  const Index n = states.x.rows(), n_energies = states.energy.size();
  Columns columns{MatrixXd(3 * n + n_energies, 3 * n), MatrixXd(3 * n + n_energies, 6)};
  for (Index i = 0; i < n; ++i) {
    const Vector3d x = states.x.row(i);
    columns.stiffness.middleRows<3>(3 * i) = stiffness_columns(x);
    for (Index j = 0; j < n; ++j)
      columns.centers.block<3, 3>(3 * i, 3 * j) = anchored_kernel(x, states.x.row(j).transpose(), shape);
    if (n_energies == 0) continue;
    columns.stiffness.row(3 * n + i) = x.transpose() * stiffness_columns(x) / 2;
    for (Index j = 0; j < n; ++j)
      columns.centers.block<1, 3>(3 * n + i, 3 * j) =
          anchored_energy(x, states.x.row(j).transpose(), shape).transpose();
  }
  return columns;
}

VectorXd stacked(const ForceStates& states) { return states.force.reshaped<Eigen::RowMajor>(); }

/// Forces, then energies over R that are known.
VectorXd targets(const ForceStates& states) {
  VectorXd all(3 * states.force.rows() + states.energy.size());
  all << stacked(states), states.energy.array().isNaN().select(0.0, states.energy.array()).matrix();
  return all;
}

double mean_length(const VectorXd& stacked_vectors) {
  double sum = 0;
  for (Index i = 0; i < stacked_vectors.size(); i += 3) sum += stacked_vectors.segment<3>(i).norm();
  return sum / std::max(1.0, static_cast<double>(stacked_vectors.size()) / 3);
}

/// Weights of the states: 1 for small forces, less for large ones. Next to a fixed part a body may snap through, with
/// forces a hundred times larger than all others; with equal weights these would distort the network everywhere else.
VectorXd weights_of(const ForceStates& states) {
  const VectorXd size = states.force.rowwise().norm();
  VectorXd sorted = size;
  std::sort(sorted.data(), sorted.data() + sorted.size());
  const double usual = typical_force_share * sorted[sorted.size() / 2];
  return usual > 0 ? VectorXd(usual / (usual + size.array())) : VectorXd(VectorXd::Ones(size.size()));
}

/// Weight of an energy over R, beside the forces of its state. Mean errors of scenes/demo.toml with 1, 3 and 10: 0.20,
/// 0.20 and 0.21 % (100 probes of 40 nodes).
constexpr double energy_weight = 3;

/// Weights of the rows of columns_of(); 0 for an energy that is not known.
VectorXd row_weights(const ForceStates& states) {
  const VectorXd of_state = weights_of(states);
  VectorXd all(3 * of_state.size() + states.energy.size());
  all.head(3 * of_state.size()) = of_state.replicate(1, 3).reshaped<Eigen::RowMajor>();
  for (Index i = 0; i < states.energy.size(); ++i)
    all[3 * of_state.size() + i] = std::isnan(states.energy[i]) ? 0 : energy_weight * of_state[i];
  return all;
}

double largest_force(const ForceStates& states) { return std::sqrt(states.force.rowwise().squaredNorm().maxCoeff()); }

/// Every `stride`-th state of each direction, including the deepest.
ForceStates every_nth_state(const ForceStates& states, std::size_t stride) {
  std::vector<Index> kept;
  for (std::size_t end = states.row.size(), i = end; i-- > 0;) {
    if (states.direction[i] != states.direction[end - 1]) end = i + 1;
    if ((end - 1 - i) % stride == 0) kept.push_back(static_cast<Index>(i));
  }
  std::reverse(kept.begin(), kept.end());
  ForceStates some;
  some.x = states.x(kept, Eigen::all);
  some.force = states.force(kept, Eigen::all);
  if (states.energy.size() > 0) some.energy = states.energy(kept);
  for (const auto i : kept) {
    some.row.push_back(states.row[static_cast<std::size_t>(i)]);
    some.direction.push_back(states.direction[static_cast<std::size_t>(i)]);
  }
  return some;
}

/// Mean error with one direction at a time left out, over the largest force. The interpolant of all other states, and
/// of zero force at rest, has a constant and a symmetric stiffness.
double left_out_error(const ForceStates& states, double shape) {
  const Index n = states.x.rows() + 1;
  MatrixXd phi(3 * n, 3 * n), tail(3 * n, 9);
  const auto place = [&](Index i) -> Vector3d {
    return i == 0 ? Vector3d::Zero() : Vector3d(states.x.row(i - 1).transpose());
  };
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) phi.block<3, 3>(3 * i, 3 * j) = force_kernel(place(i) - place(j), shape);
    tail.middleRows<3>(3 * i) << Matrix3d::Identity(), stiffness_columns(place(i));
  }
  VectorXd values = VectorXd::Zero(3 * n);
  values.tail(3 * (n - 1)) = stacked(states);
  const MatrixXd errors = left_out(phi, tail, values, groups_of_equal(states.direction, 3, 3));
  return mean_length(errors.col(0).tail(3 * (n - 1))) / largest_force(states);
}

/// The columns scaled to unit length, with rows of damping for the first n_damped columns.
MatrixXd damped_columns(const MatrixXd& a, const VectorXd& size, Index n_damped) {
  MatrixXd unit = MatrixXd::Zero(a.rows() + n_damped, a.cols());
  unit.topRows(a.rows()) = a * size.cwiseInverse().asDiagonal();
  unit.bottomRows(n_damped).diagonal().setConstant(damping);
  return unit;
}

VectorXd column_sizes(const MatrixXd& a) {
  return a.colwise().norm().transpose().cwiseMax(std::numeric_limits<double>::min());
}

/// Least squares solution of a x = b with columns scaled to unit length, of which the first n_damped are damped.
VectorXd damped_solution(const MatrixXd& a, const VectorXd& b, Index n_damped) {
  if (a.cols() == 0) return VectorXd(0);
  const VectorXd size = column_sizes(a);
  const MatrixXd unit = damped_columns(a, size, n_damped);
  VectorXd right = VectorXd::Zero(unit.rows());
  right.head(b.size()) = b;
  return least_squares_vector(unit, right).cwiseQuotient(size);
}

Matrix3d symmetric(const Eigen::Matrix<double, 6, 1>& k) {
  Matrix3d m;
  m << k[0], k[1], k[2], k[1], k[3], k[4], k[2], k[4], k[5];
  return m;
}

/// Lower bound of the eigenvalues of K: a fraction of the smallest eigenvalue of the best linear stiffness of all
/// states.
double least_tail(const MatrixXd& stiffness_columns, const VectorXd& force) {
  const Matrix3d best = symmetric(damped_solution(stiffness_columns, force, 0));
  return least_tail_share * std::max(0.0, symmetric_eigen3(best).values[0]);
}

/// The matrix with eigenvalues below `least` replaced by `least`; unchanged if there are none.
Matrix3d with_eigenvalues_at_least(const Matrix3d& k, double least) {
  const SymmetricEigen3 eigen = symmetric_eigen3(k);
  if (eigen.values[0] >= least) return k;
  const Matrix3d raised = eigen.with_values(eigen.values.cwiseMax(least));
  return (raised + raised.transpose()) / 2;
}

/// Data and parameters of a fit.
struct Problem {
  const ForceStates& states;
  double max_displacement_m, shape;
  Columns columns;
  VectorXd target, weights;  ///< of their rows
};

/// Least squares with the given centers, in ascending order. @param left_out_error  output, may be null
ConservativeFit fit_centers(const Problem& problem, const std::vector<Index>& chosen, double* left_out_error) {
  const auto& [states, max_displacement_m, shape, columns, targets, weights] = problem;
  const auto m = static_cast<Index>(chosen.size()), n_forces = 3 * states.x.rows();
  MatrixXd a(targets.size(), 3 * m + 6);
  for (Index j = 0; j < m; ++j)
    a.middleCols<3>(3 * j) = columns.centers.middleCols<3>(3 * chosen[static_cast<std::size_t>(j)]);
  a.rightCols<6>() = columns.stiffness;
  const MatrixXd weighted = weights.asDiagonal() * a;
  const VectorXd target = weights.cwiseProduct(targets);
  VectorXd solution = damped_solution(weighted, target, 3 * m);
  Index n_free = a.cols();
  // At large displacements only this stiffness remains; it must not push the tool away.
  const Matrix3d tail =
      with_eigenvalues_at_least(symmetric(solution.tail<6>()), least_tail(weighted.rightCols<6>(), target));
  if (tail != symmetric(solution.tail<6>())) {
    n_free = 3 * m;
    solution.tail<6>() << tail(0, 0), tail(0, 1), tail(0, 2), tail(1, 1), tail(1, 2), tail(2, 2);
    solution.head(3 * m) = damped_solution(weighted.leftCols(3 * m),
                                           residual_of(target, weighted.rightCols<6>(), solution.tail<6>()), 3 * m);
  }

  ConservativeFit fit;
  auto& network = fit.network;
  network.shape = shape;
  network.coefficients.resize(m, 3);
  for (Index j = 0; j < m; ++j) {
    network.centers.push_back(states.row[static_cast<std::size_t>(chosen[static_cast<std::size_t>(j)])]);
    network.coefficients.row(j) = solution.segment<3>(3 * j).transpose().cast<float>().cast<double>();
    solution.segment<3>(3 * j) = network.coefficients.row(j);
  }
  const auto k = [&](Index i) {
    return static_cast<double>(static_cast<float>(solution[3 * m + i] / problem.max_displacement_m));
  };
  network.stiffness << k(0), k(1), k(2), k(1), k(3), k(4), k(2), k(4), k(5);
  const double largest = largest_force(states);
  if (largest > 0) {
    fit.training_error = mean_length((applied(a, solution) - targets).head(n_forces)) / largest;
    fit.cancellation = (a.topRows(n_forces).cwiseAbs() * solution.cwiseAbs()).maxCoeff() / largest;
  }
  if (largest > 0 && left_out_error) {
    const MatrixXd free = weighted.leftCols(n_free);
    auto groups = groups_of_equal(states.row, 3, 0);
    for (Index i = 0; i < states.energy.size(); ++i) groups[static_cast<std::size_t>(i)].push_back(n_forces + i);
    const MatrixXd errors = left_out_of_fit(damped_columns(free, column_sizes(free), 3 * m),
                                            residual_of(target, weighted, solution), target, groups);
    *left_out_error = mean_length(errors.col(0).head(n_forces).cwiseQuotient(weights.head(n_forces))) / largest;
  }
  return fit;
}

ConservativeFit fit_shape(const ForceStates& states, double max_displacement_m, int max_centers, double shape,
                          int n_levels) {
  const Problem problem{states,          max_displacement_m, shape, columns_of(states, shape),
                        targets(states), row_weights(states)};
  const auto& columns = problem.columns;
  const int allowed = static_cast<int>(largest_center_share * static_cast<double>(problem.target.size()) / 3);
  const auto order =
      choose_centers({problem.weights.asDiagonal() * columns.centers, problem.weights.asDiagonal() * columns.stiffness},
                     problem.weights.cwiseProduct(problem.target), std::min(max_centers, allowed));
  const auto first = [&](int n) {
    std::vector<Index> some(order.begin(), order.begin() + n);
    std::sort(some.begin(), some.end());
    return some;
  };
  const int n_all = static_cast<int>(order.size());
  auto fit = fit_centers(problem, first(n_all), nullptr);
  for (int below = n_levels - 1; below >= 0 && n_levels > 1; --below) {
    auto& level = fit.levels.emplace_back();
    const int n = level_size(n_all, below, least_force_centers);
    level.network = fit_centers(problem, first(n), &level.left_out_error).network;
  }
  return fit;
}

/// The shape with the smallest left-out error, and this error, as ConservativeFit::left_out_error.
struct ShapeChoice {
  double shape = 0, left_out_error = 0;
};
ShapeChoice choose_force_shape(const ForceStates& states) {
  const ForceStates some = every_nth_state(states, (states.row.size() + max_search_states - 1) / max_search_states);
  ShapeChoice best{shape_candidates.front(), std::numeric_limits<double>::infinity()};
  for (const double shape : shape_candidates) {
    const double error = largest_force(some) > 0 ? left_out_error(some, shape) : 0;
    if (error < best.left_out_error) best = {shape, error};
  }
  return best;
}

}  // namespace

ForceStates force_states(const TrainingTables& tables, const std::vector<Ray>& rays) {
  const NetworkPoints points = force_points(tables, rays);
  ForceStates states;
  states.row = points.displacement;
  const auto n = static_cast<Index>(points.size());
  states.x.resize(n, 3);
  states.force = points.outputs;
  for (Index i = 0; i < n; ++i) {
    const auto row = states.row[static_cast<std::size_t>(i)];
    states.x.row(i) = tables.displacements.row(row) / tables.magnitudes_m.back();
    states.direction.push_back(row / tables.n_increments);
  }
  // Beyond a fold energy is lost.
  states.energy.resize(n);
  for (Index i = 0; i < n; ++i) {
    const auto row = states.row[static_cast<std::size_t>(i)];
    const auto increment = static_cast<std::size_t>(row % tables.n_increments);
    const Ray& ray = rays[static_cast<std::size_t>(row / tables.n_increments)];
    const bool known = increment < ray.energy.size() &&
                       !(ray.end.fold_depth_m > 0 && tables.magnitudes_m[increment] >= ray.end.fold_depth_m);
    states.energy[i] = known ? ray.energy[increment] / tables.magnitudes_m.back() : std::nan("");
  }
  if (!(states.energy.array() > 0).any()) states.energy.resize(0);
  return states;
}

ConservativeFit fit_conservative(const ForceStates& all, double max_displacement_m, int max_centers, int n_levels) {
  const ForceStates states = every_nth_state(all, (all.row.size() + max_fit_states - 1) / max_fit_states);
  auto [shape, left_out] = choose_force_shape(states);
  auto fit = fit_shape(states, max_displacement_m, max_centers, shape, n_levels);
  // Flat kernels cause cancellation; use the next sharper one.
  while (fit.cancellation > largest_cancellation && shape > shape_candidates.front()) {
    shape = *std::prev(std::ranges::lower_bound(shape_candidates, shape));
    fit = fit_shape(states, max_displacement_m, max_centers, shape, n_levels);
  }
  fit.left_out_error = left_out;
  return fit;
}

Vector3d evaluate_force(const ConservativeNetwork& network, const Points& displacements, double max_displacement_m,
                        const Vector3d& x) {
  Vector3d force = network.stiffness * (max_displacement_m * x);
  for (std::size_t i = 0; i < network.centers.size(); ++i) {
    const Vector3d c = displacements.row(network.centers[i]).transpose() / max_displacement_m;
    force += anchored_kernel(x, c, network.shape) * network.coefficients.row(static_cast<Index>(i)).transpose();
  }
  return force;
}

}  // namespace phynness
