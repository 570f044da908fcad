#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/training/modal_fit.hpp>
#include <set>
#include <string>

#include "fixed_shapes.hpp"
#include "left_out.hpp"
#include "modal/multiquadric.hpp"
#include "sampling.hpp"

namespace phynness {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Modes smaller than this part of the largest are rounding of the data (float32).
constexpr double smallest_mode = 1e-6;

/// More states than this make a search slow and no better: what is left out is whole directions.
constexpr std::size_t max_search_states = 100;

/// Damping of the amplitudes' least squares, in columns of unit length: without it, weights of opposite signs
/// grow where a body snaps, and errors beyond the trained range by a quarter; ten times more would cost
/// accuracy inside.
constexpr double damping = 1e-3;

/// Displacements this close, in the largest, are the same but for rounding.
constexpr double same_place = 1e-9;

/// More columns than asked for and rounds of subspace iteration: the spectrum falls by half within a few
/// modes, so that 8 columns and 3 rounds leave the subspace converged beyond what 16 bits show.
constexpr int spare_columns = 8, rounds = 3;

/// Products of two components of a displacement.
constexpr int n_even = 6;

Eigen::MatrixX3d scaled_rows(const TrainingTables& tables, const std::vector<std::int32_t>& rows) {
  Eigen::MatrixX3d x(static_cast<Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i)
    x.row(static_cast<Index>(i)) = tables.displacements.row(rows[i]) / tables.magnitudes_m.back();
  return x;
}

/// n x (centers + 3), of a field + 9: the amplitudes' features at each x.
/// @param degree  of a field near rest; 0: a displacement
MatrixXd features(const Eigen::MatrixX3d& x, const Eigen::MatrixX3d& centers, double shape, int degree = 0) {
  const Index n_centers = centers.rows();
  MatrixXd f(x.rows(), n_centers + 3 + (degree > 0 ? n_even : 0));
  for (Index i = 0; i < x.rows(); ++i)
    for (Index j = 0; j < n_centers; ++j)
      f(i, j) = anchored_multiquadric(x.row(i).transpose(), centers.row(j).transpose(), shape);
  f.middleCols<3>(n_centers) = x;
  if (degree > 0)
    for (Index i = 0; i < x.rows(); ++i)
      f.row(i).tail<n_even>() = even_features(x.row(i).transpose(), degree).transpose();
  return f;
}

MatrixXd orthonormal(const MatrixXd& a) {
  return Eigen::HouseholderQR<MatrixXd>(a).householderQ() *
         MatrixXd::Identity(a.rows(), std::min(a.rows(), a.cols()));
}

/// Mean over rows and output nodes not moved by the probe of |displacement| (of a field: |value|) / largest.
double mean_share(const MatrixXd& fields, const NodeModes& node) {
  double sum = 0;
  Index n = 0;
  const Index k = node.components;
  for (std::size_t o = 0; o < node.moved.size(); ++o) {
    if (node.moved[o]) continue;
    for (Index i = 0; i < fields.rows(); ++i)
      sum += fields.row(i).segment(k * static_cast<Index>(o), k).norm();
    n += fields.rows();
  }
  return n > 0 && node.largest > 0 ? sum / static_cast<double>(n) / node.largest : 0;
}

/// Amplitudes at directions left out, mean over states: root mean square over nodes of their error, over the
/// largest displacement of a node. (Modes are orthonormal: the size of an amplitude vector is that of the
/// whole field.)
double left_out_error(const TrainingTables& tables, const NodeModes& node, double shape) {
  // The same displacement twice would make the matrix singular, close neighbours along a direction singular
  // to rounding.
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < node.row.size(); ++i)
    if (std::none_of(places.begin(), places.end(), [&](std::size_t j) {
          return (tables.displacements.row(node.row[i]) - tables.displacements.row(node.row[j])).norm() <=
                 same_place * tables.magnitudes_m.back();
        }))
      places.push_back(i);
  std::vector<Index> kept;
  std::vector<std::int32_t> rows, directions;
  const auto stride = static_cast<std::int32_t>((places.size() + max_search_states - 1) / max_search_states);
  for (const auto i : places) {
    const auto increment = node.row[i] % tables.n_increments;
    if ((tables.n_increments - 1 - increment) % stride != 0) continue;
    kept.push_back(static_cast<Index>(i));
    rows.push_back(node.row[i]);
    directions.push_back(node.direction[i]);
  }
  const auto x = scaled_rows(tables, rows);
  const Index n = x.rows() + 1;
  if (n == 1) return 0;
  MatrixXd phi(n, n), tail = MatrixXd::Ones(n, 4), values = MatrixXd::Zero(n, node.amplitudes.cols());
  values.bottomRows(n - 1) = rows_of(node.amplitudes, kept);
  const auto place = [&](Index i) -> Vector3d {
    return i == 0 ? Vector3d::Zero() : Vector3d(x.row(i - 1).transpose());
  };
  for (Index i = 0; i < n; ++i) {
    tail.row(i).tail<3>() = place(i).transpose();
    for (Index j = 0; j < n; ++j) phi(i, j) = multiquadric(place(i) - place(j), shape);
  }
  const MatrixXd errors = left_out(phi, tail, values, groups_of_equal(directions, 1, 1));
  const double n_output = static_cast<double>(node.modes.rows()) / node.components;
  return node.largest > 0
             ? errors.bottomRows(n - 1).rowwise().norm().mean() / std::sqrt(n_output) / node.largest
             : 0;
}

/// The least squares of the amplitudes: features in columns of unit length, damped.
struct AmplitudeProblem {
  explicit AmplitudeProblem(const MatrixXd& f)
      : size(f.colwise().norm().transpose().cwiseMax(std::numeric_limits<double>::min())),
        unit(f * size.cwiseInverse().asDiagonal()),
        normal(unit.transpose() * unit) {
    normal.diagonal().array() += damping * damping;
  }
  VectorXd size;
  MatrixXd unit, normal;
};

/// Amplitudes of a level, fitted to its centers alone. @param stored  modes as the model holds them
ModalFit::Level fit_level(const TrainingTables& tables, const AmplitudeLevel& level, double shape, int degree,
                          const NodeModes& node, const MatrixXd& stored) {
  const Index n_modes = std::min<Index>(level.modes, node.modes.cols());
  const AmplitudeProblem problem(
      features(scaled_rows(tables, node.row), scaled_rows(tables, level.centers), shape, degree));
  const MatrixXd wanted = node.amplitudes.leftCols(n_modes);
  const MatrixXd weights = problem.normal.ldlt().solve(problem.unit.transpose() * wanted);
  ModalFit::Level fit;
  fit.weights = scaled_table(problem.size.cwiseInverse().asDiagonal() * weights);
  MatrixXd damped = MatrixXd::Zero(problem.unit.rows() + problem.unit.cols(), problem.unit.cols());
  damped.topRows(problem.unit.rows()) = problem.unit;
  damped.bottomRows(problem.unit.cols()).diagonal().setConstant(damping);
  const MatrixXd errors =
      left_out_of_fit(damped, wanted - problem.unit * weights, wanted, groups_of_equal(node.row, 1, 0));
  fit.left_out_error = node.lost + mean_share((wanted - errors) * stored.leftCols(n_modes).transpose() -
                                                  node.amplitudes * node.modes.transpose(),
                                              node);
  return fit;
}

/// One node's part in the choice of centers: what its states say of each candidate.
struct Chooser {
  MatrixXd columns,
      rest;  ///< states x candidates, states x modes; orthogonal to the linear part and to what was chosen
  VectorXd first;  ///< squared lengths of the columns at the start
};

Chooser chooser(const TrainingTables& tables, const NodeModes& node, const Eigen::MatrixX3d& candidates,
                double shape) {
  Chooser c;
  const MatrixXd f = features(scaled_rows(tables, node.row), candidates, shape);
  const MatrixXd linear = orthonormal(f.rightCols<3>());
  c.columns = f.leftCols(candidates.rows());
  c.columns -= linear * (linear.transpose() * c.columns);
  c.rest = node.amplitudes / std::max(node.largest, std::numeric_limits<double>::min());
  c.rest -= linear * (linear.transpose() * c.rest);
  c.first = c.columns.colwise().squaredNorm();
  return c;
}

/// How much of each candidate is left, and what it would explain; nothing where what is left is rounding.
VectorXd explained(const Chooser& c) {
  const VectorXd left = c.columns.colwise().squaredNorm();
  const VectorXd slope = (c.columns.transpose() * c.rest).rowwise().squaredNorm();
  return (left.array() > 1e-10 * c.first.array()).select(slope.array() / left.array(), 0.0);
}

void remove(Chooser& c, Index candidate) {
  const double size = c.columns.col(candidate).norm();
  if (!(size > 0)) return;
  const VectorXd direction = c.columns.col(candidate) / size;
  c.columns -= direction * (direction.transpose() * c.columns);
  c.rest -= direction * (direction.transpose() * c.rest);
}

/// A node that has its states and `moved`, and no modes yet.
NodeModes node_of(const TrainingTables& tables, const std::vector<Ray>& rays, int components) {
  NodeModes node;
  node.components = components;
  node.row = converged_increments(tables, rays);
  for (const auto row : node.row) node.direction.push_back(row / tables.n_increments);
  node.moved.assign(tables.output.size(), 0);
  return node;
}

/// What each state of the node holds, one per row; `values(ray)` are those of all of a ray's increments.
template <typename Values>
MatrixXd states_of(const TrainingTables& tables, const std::vector<Ray>& rays, const NodeModes& node,
                   const Values& values) {
  const std::size_t columns = static_cast<std::size_t>(node.components) * tables.output.size();
  MatrixXd u(static_cast<Index>(node.row.size()), static_cast<Index>(columns));
  for (Index i = 0; i < u.rows(); ++i) {
    const auto row = node.row[static_cast<std::size_t>(i)];
    const std::vector<double>& of_ray = values(rays[static_cast<std::size_t>(row / tables.n_increments)]);
    const double* from = &of_ray[columns * static_cast<std::size_t>(row % tables.n_increments)];
    u.row(i) = Eigen::Map<const Eigen::RowVectorXd>(from, u.cols());
  }
  if (!u.allFinite())
    throw failure("database holds a " + std::string(node.components == 3 ? "displacement" : "field") +
                      " that is not finite in an increment marked converged",
                  "", "precompute this database again");
  return u;
}

/// Fills in modes, amplitudes and what is said of them.
void decompose(const MatrixXd& u, int max_modes, NodeModes& node) {
  const Index n = u.rows(), k = node.components;
  for (Index o = 0; o < u.cols() / k; ++o)
    for (Index i = 0; i < n; ++i) node.largest = std::max(node.largest, u.row(i).segment(k * o, k).norm());
  if (n == 0) return;
  // Fewer states than unknowns: the small Gram matrix has the same singular values.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(u * u.transpose());
  const VectorXd squares = eigen.eigenvalues().reverse().cwiseMax(0);
  Index m = 0;
  while (m < std::min<Index>(n, max_modes) && squares[m] > smallest_mode * smallest_mode * squares[0]) ++m;
  if (m == 0 && max_modes > 0) {
    // Nothing moves but what the probe moves itself: one mode, of zeros.
    node.size = VectorXd::Zero(1);
    node.modes = MatrixXd::Zero(u.cols(), 1);
    node.amplitudes = MatrixXd::Zero(n, 1);
    return;
  }
  node.size = squares.head(m).cwiseSqrt();
  const MatrixXd left = eigen.eigenvectors().rowwise().reverse().leftCols(m);
  node.modes = u.transpose() * left * node.size.cwiseInverse().asDiagonal();
  node.amplitudes = left * node.size.asDiagonal();
  node.lost = mean_share(u - node.amplitudes * node.modes.transpose(), node);
}

}  // namespace

std::vector<double> amplitude_shape_candidates() { return {0.03, 0.1, 0.3, 0.6, 1.0}; }

Eigen::Matrix<double, 6, 1> even_features(const Vector3d& x, int degree) {
  const double size = x.norm();
  if (!(size > 0)) return Eigen::Matrix<double, 6, 1>::Zero();
  const double by = degree == 1 ? size : 1;
  Eigen::Matrix<double, 6, 1> e;
  e << x[0] * x[0], x[0] * x[1], x[0] * x[2], x[1] * x[1], x[1] * x[2], x[2] * x[2];
  return e / by;
}

NodeModes node_modes(const TrainingTables& tables, const TouchedNodes& prescribed,
                     const std::vector<Ray>& rays, int max_modes) {
  auto node = node_of(tables, rays, 3);
  MatrixXd u = states_of(tables, rays, node,
                         [](const Ray& ray) -> const std::vector<double>& { return ray.displacement; });
  for (std::size_t o = 0; o < tables.output.size(); ++o) {
    node.moved[o] = std::binary_search(prescribed.nodes.begin(), prescribed.nodes.end(), tables.output[o]);
    if (node.moved[o]) u.middleCols<3>(3 * static_cast<Index>(o)).setZero();
  }
  decompose(u, max_modes, node);
  return node;
}

NodeModes field_modes(const TrainingTables& tables, const std::vector<Ray>& rays, std::size_t field,
                      double scale, int max_modes) {
  auto node = node_of(tables, rays, 1);
  const MatrixXd values =
      states_of(tables, rays, node,
                [field](const Ray& ray) -> const std::vector<double>& { return ray.fields.at(field); });
  decompose(values / scale, max_modes, node);
  return node;
}

MatrixXd shared_basis(const std::vector<NodeModes>& nodes, int n_shared, std::uint64_t seed) {
  Index n_rows = 0, n_columns = 0;
  for (const auto& node : nodes) {
    n_rows = std::max(n_rows, node.modes.rows());
    n_columns += node.modes.cols();
  }
  const auto wanted = std::min<Index>({n_shared, n_rows, n_columns});
  if (wanted == 0) return MatrixXd(n_rows, 0);
  MatrixXf all(n_rows, n_columns);
  Index at = 0;
  for (const auto& node : nodes) {
    const double weight = node.largest > 0 ? 1 / node.largest : 0;
    all.middleCols(at, node.modes.cols()) = (node.modes * (weight * node.size).asDiagonal()).cast<float>();
    at += node.modes.cols();
  }
  const Index width = std::min<Index>({wanted + spare_columns, n_rows, n_columns});
  SplitMix64 random(seed);
  MatrixXd basis(n_rows, width);
  for (Index i = 0; i < basis.size(); ++i)
    basis.data()[i] = static_cast<double>(random.next() >> 11) * 0x1p-53 - 0.5;
  MatrixXf inner;
  for (int round = 0; round < rounds; ++round) {
    basis = orthonormal(basis);
    inner.noalias() = all.transpose() * basis.cast<float>();
    basis = (all * inner).cast<double>();
  }
  basis = orthonormal(basis);
  inner.noalias() = all.transpose() * basis.cast<float>();
  const MatrixXd small = inner.cast<double>();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(small.transpose() * small);
  return basis * eigen.eigenvectors().rowwise().reverse().leftCols(wanted);
}

AmplitudeCenters choose_amplitude_centers(const TrainingTables& tables, const std::vector<NodeModes>& nodes,
                                          int max_centers) {
  AmplitudeCenters chosen;
  if (std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.row.empty(); }))
    return chosen;
  chosen.left_out_error = std::numeric_limits<double>::infinity();
  for (const double candidate : amplitude_shape_candidates()) {
    // The median: a node where the body snaps is predicted by no shape, and would outweigh all others.
    std::vector<double> errors;
    for (const auto& node : nodes) errors.push_back(left_out_error(tables, node, candidate));
    std::sort(errors.begin(), errors.end());
    const double error = errors[(errors.size() - 1) / 2];
    if (error < chosen.left_out_error) {
      chosen.left_out_error = error;
      chosen.shape = candidate;
    }
  }
  const auto centers = amplitude_centers_of_shape(tables, nodes, max_centers, chosen.shape);
  chosen.row = centers.row;
  chosen.order = centers.order;
  return chosen;
}

AmplitudeCenters amplitude_centers_of_shape(const TrainingTables& tables, const std::vector<NodeModes>& nodes,
                                            int max_centers, double shape) {
  AmplitudeCenters chosen;
  chosen.shape = shape;
  std::set<std::int32_t> every;
  for (const auto& node : nodes) every.insert(node.row.begin(), node.row.end());
  // Candidates are the states of any node; nodes that face different ways have different ones.
  const std::vector<std::int32_t> rows(every.begin(), every.end());
  const auto x = scaled_rows(tables, rows);
  std::vector<Chooser> choosers;
  for (const auto& node : nodes)
    if (!node.row.empty()) choosers.push_back(chooser(tables, node, x, shape));
  std::vector<char> open(rows.size(), 1);
  while (!rows.empty() && static_cast<int>(chosen.row.size()) < max_centers) {
    VectorXd sum = VectorXd::Zero(x.rows());
    for (const auto& c : choosers) sum += explained(c);
    for (Index i = 0; i < x.rows(); ++i)
      if (!open[static_cast<std::size_t>(i)]) sum[i] = 0;
    Index best = 0;
    if (!(sum.maxCoeff(&best) > 0)) break;
    open[static_cast<std::size_t>(best)] = 0;
    chosen.row.push_back(rows[static_cast<std::size_t>(best)]);
    for (auto& c : choosers) remove(c, best);
  }
  chosen.order = chosen.row;
  std::sort(chosen.row.begin(), chosen.row.end());
  return chosen;
}

ModalFit fit_modal(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node, int n_near,
                   int degree, const std::vector<AmplitudeLevel>& levels) {
  ModalFit fit;
  auto& modal = fit.deformation;
  const MatrixXd basis = shared.modes.values();
  const Index k = node.components, n_output = basis.rows() / k, m = node.modes.cols();

  // Near nodes: where the shared modes miss most, the sizes of the modes counted in.
  MatrixXd mixing = basis.transpose() * node.modes;
  const MatrixXd missing = (node.modes - basis * mixing) * node.size.asDiagonal();
  std::vector<std::pair<double, std::int32_t>> worst;
  for (Index o = 0; o < n_output; ++o)
    if (!node.moved[static_cast<std::size_t>(o)])
      worst.emplace_back(-missing.middleRows(k * o, k).squaredNorm(), static_cast<std::int32_t>(o));
  std::sort(worst.begin(), worst.end());
  for (std::size_t i = 0; i < std::min<std::size_t>(worst.size(), static_cast<std::size_t>(n_near)); ++i)
    modal.near.push_back(worst[i].second);
  std::sort(modal.near.begin(), modal.near.end());
  MatrixXd far = basis, target = node.modes, near(k * static_cast<Index>(modal.near.size()), m);
  for (std::size_t i = 0; i < modal.near.size(); ++i)
    near.middleRows(k * static_cast<Index>(i), k) = node.modes.middleRows(k * modal.near[i], k);
  const auto without = [&](Index o) {
    far.middleRows(k * o, k).setZero();
    target.middleRows(k * o, k).setZero();
  };
  for (const auto o : modal.near) without(o);
  for (Index o = 0; o < n_output; ++o)
    if (node.moved[static_cast<std::size_t>(o)]) without(o);
  if (basis.cols() > 0)
    mixing = Eigen::CompleteOrthogonalDecomposition<MatrixXd>(far.transpose() * far)
                 .solve(far.transpose() * target);

  const auto x = scaled_rows(tables, node.row);
  const MatrixXd f = features(x, scaled_rows(tables, shared.centers), shared.shape, degree);
  const AmplitudeProblem problem(f);
  const MatrixXd weights = problem.size.cwiseInverse().asDiagonal() *
                           problem.normal.ldlt().solve(problem.unit.transpose() * node.amplitudes);

  modal.weights = scaled_table(weights);
  modal.mixing = scaled_table(mixing);
  modal.near_modes = scaled_table(near);

  MatrixXd stored = basis * modal.mixing.values();
  const MatrixXd stored_near = modal.near_modes.values();
  for (std::size_t i = 0; i < modal.near.size(); ++i)
    stored.middleRows(k * modal.near[i], k) = stored_near.middleRows(k * static_cast<Index>(i), k);
  for (Index o = 0; o < n_output; ++o)
    if (node.moved[static_cast<std::size_t>(o)]) stored.middleRows(k * o, k).setZero();
  fit.truncation_error = node.lost + mean_share(node.amplitudes * (stored - node.modes).transpose(), node);
  fit.regression_error =
      mean_share((f * modal.weights.values() - node.amplitudes) * stored.transpose(), node);
  for (const auto& level : levels)
    fit.levels.push_back(fit_level(tables, level, shared.shape, degree, node, stored));
  return fit;
}

double condition_number(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node) {
  const AmplitudeProblem problem(
      features(scaled_rows(tables, node.row), scaled_rows(tables, shared.centers), shared.shape));
  const VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(problem.normal, Eigen::EigenvaluesOnly).eigenvalues();
  return values[values.size() - 1] / values[0];
}

}  // namespace phynness
