#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/training/modal_fit.hpp>
#include <string>

#include "dense_products.hpp"
#include "dense_solvers.hpp"
#include "left_out.hpp"
#include "modal_parts.hpp"
#include "sampling.hpp"

namespace phynness {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Modes below this fraction of the largest are rounding errors of the data (float32).
constexpr double smallest_mode = 1e-6;

/// Damping of the least squares of amplitudes for columns scaled to unit length. Without it, where a body snaps
/// through, large weights of opposite signs occur and errors outside of the trained range are larger by a quarter. Ten
/// times more damping would reduce the accuracy inside.
constexpr double amplitude_damping = 1e-3;

/// Additional columns and rounds of the subspace iteration. The singular values decrease by half within a few modes, so
/// that with 8 columns and 3 rounds the error of the subspace is below the resolution of 16 bits.
constexpr int spare_columns = 8, rounds = 3;

/// Mean of |displacement| (for a field |value|) / largest over rows and output nodes that the probe does not move.
double relative_error(const MatrixXd& fields, const NodeModes& node) {
  double sum = 0;
  Index n = 0;
  const Index k = node.components;
  for (std::size_t o = 0; o < node.prescribed.size(); ++o) {
    if (node.prescribed[o]) continue;
    for (Index i = 0; i < fields.rows(); ++i) sum += fields.row(i).segment(k * static_cast<Index>(o), k).norm();
    n += fields.rows();
  }
  return n > 0 && node.largest_value > 0 ? sum / static_cast<double>(n) / node.largest_value : 0;
}

/// The damped least squares problem of the amplitudes, with features scaled to columns of unit length.
struct AmplitudeProblem {
  explicit AmplitudeProblem(const MatrixXd& f)
      : size(f.colwise().norm().transpose().cwiseMax(std::numeric_limits<double>::min())),
        unit(f * size.cwiseInverse().asDiagonal()),
        normal(transposed_product(unit, unit)) {
    normal.diagonal().array() += amplitude_damping * amplitude_damping;
  }
  VectorXd size;
  MatrixXd unit, normal;
};

/// Fits the amplitudes of a level with its centers only. @param stored  modes as stored in the model
ModalFit::Level fit_level(const TrainingTables& tables, const AmplitudeLevel& level, double shape, int degree,
                          const NodeModes& node, const MatrixXd& stored) {
  const Index n_modes = std::min<Index>(level.modes, node.modes.cols());
  const AmplitudeProblem problem(
      features(scaled_rows(tables, node.row), scaled_rows(tables, level.centers), shape, degree));
  const MatrixXd wanted = node.amplitudes.leftCols(n_modes);
  const MatrixXd weights = solve_positive_definite(problem.normal, transposed_product(problem.unit, wanted));
  ModalFit::Level fit;
  fit.weights = scaled_table(problem.size.cwiseInverse().asDiagonal() * weights);
  MatrixXd damped = MatrixXd::Zero(problem.unit.rows() + problem.unit.cols(), problem.unit.cols());
  damped.topRows(problem.unit.rows()) = problem.unit;
  damped.bottomRows(problem.unit.cols()).diagonal().setConstant(amplitude_damping);
  MatrixXd residual = wanted;
  subtract_product(residual, problem.unit, weights);
  const MatrixXd errors = left_out_of_fit(damped, residual, wanted, groups_of_equal(node.row, 1, 0));
  MatrixXd difference = product_transposed(wanted - errors, stored.leftCols(n_modes));
  subtract_product_transposed(difference, node.amplitudes, node.modes);
  fit.left_out_error = node.truncation_error + relative_error(difference, node);
  return fit;
}

/// A node with its states and `moved`, without modes.
NodeModes node_of(const TrainingTables& tables, const std::vector<Ray>& rays, int components) {
  NodeModes node;
  node.components = components;
  TrainingStates states = training_states(tables, rays);
  node.row = std::move(states.row);
  node.increments = std::move(states.increments);
  for (const auto row : node.row) node.direction.push_back(row / tables.n_increments);
  node.prescribed.assign(tables.output.size(), 0);
  return node;
}

/// Values of each state of the node, one state per row. @param values  gives the values of all increments of a ray
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
    throw failure("the database has a " + std::string(node.components == 3 ? "displacement" : "field") +
                      " that is not finite in a converged increment",
                  "", "precompute this database again");
  return u;
}

/// Sets modes, amplitudes and their errors.
void decompose(const MatrixXd& u, int max_modes, NodeModes& node) {
  const Index n = u.rows(), k = node.components;
  for (Index o = 0; o < u.cols() / k; ++o)
    for (Index i = 0; i < n; ++i) node.largest_value = std::max(node.largest_value, u.row(i).segment(k * o, k).norm());
  if (n == 0) return;
  // There are fewer states than unknowns, so that the smaller Gram matrix is decomposed, which gives the same singular
  // values.
  const SymmetricEigen eigen = symmetric_eigen(product_transposed(u, u));
  const VectorXd squares = eigen.values.reverse().cwiseMax(0);
  Index m = 0;
  while (m < std::min<Index>(n, max_modes) && squares[m] > smallest_mode * smallest_mode * squares[0]) ++m;
  if (m == 0 && max_modes > 0) {
    // Only nodes that the probe itself moves have displacements: one mode of zeros.
    node.singular_values = VectorXd::Zero(1);
    node.modes = MatrixXd::Zero(u.cols(), 1);
    node.amplitudes = MatrixXd::Zero(n, 1);
    return;
  }
  node.singular_values = squares.head(m).cwiseSqrt();
  const MatrixXd left = eigen.vectors.rowwise().reverse().leftCols(m);
  node.modes = transposed_product(u, left) * node.singular_values.cwiseInverse().asDiagonal();
  node.amplitudes = left * node.singular_values.asDiagonal();
  MatrixXd rest = u;
  subtract_product_transposed(rest, node.amplitudes, node.modes);
  node.truncation_error = relative_error(rest, node);
}

}  // namespace

NodeModes node_modes(const TrainingTables& tables, const TouchedNodes& tool, const std::vector<Ray>& rays,
                     int max_modes) {
  auto node = node_of(tables, rays, 3);
  MatrixXd u =
      states_of(tables, rays, node, [](const Ray& ray) -> const std::vector<double>& { return ray.displacement; });
  for (std::size_t o = 0; o < tables.output.size(); ++o) {
    node.prescribed[o] = tool.holds(tables.output[o]);
    if (node.prescribed[o]) u.middleCols<3>(3 * static_cast<Index>(o)).setZero();
  }
  decompose(u, max_modes, node);
  return node;
}

NodeModes field_modes(const TrainingTables& tables, const std::vector<Ray>& rays, std::size_t field, double scale,
                      int max_modes) {
  auto node = node_of(tables, rays, 1);
  const MatrixXd values = states_of(
      tables, rays, node, [field](const Ray& ray) -> const std::vector<double>& { return ray.fields.at(field); });
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
    const double weight = node.largest_value > 0 ? 1 / node.largest_value : 0;
    all.middleCols(at, node.modes.cols()) = (node.modes * (weight * node.singular_values).asDiagonal()).cast<float>();
    at += node.modes.cols();
  }
  const Index width = std::min<Index>({wanted + spare_columns, n_rows, n_columns});
  SplitMix64 random(seed);
  MatrixXd basis(n_rows, width);
  for (Index i = 0; i < basis.size(); ++i) basis.data()[i] = static_cast<double>(random.next() >> 11) * 0x1p-53 - 0.5;
  MatrixXf inner;
  for (int round = 0; round < rounds; ++round) {
    basis = orthonormal(basis);
    inner.noalias() = all.transpose() * basis.cast<float>();
    basis = (all * inner).cast<double>();
  }
  basis = orthonormal(basis);
  inner.noalias() = all.transpose() * basis.cast<float>();
  const MatrixXd small = inner.cast<double>();
  const SymmetricEigen eigen = symmetric_eigen(transposed_product(small, small));
  return product(basis, MatrixXd(eigen.vectors.rowwise().reverse().leftCols(wanted)));
}

MixedModes mix_modes(const MatrixXd& basis, const NodeModes& node, int n_near) {
  MixedModes mixed;
  const Index k = node.components, n_output = basis.rows() / k;
  mixed.mixing = transposed_product(basis, node.modes);
  const MatrixXd missing = (node.modes - product(basis, mixed.mixing)) * node.singular_values.asDiagonal();
  std::vector<std::pair<double, std::int32_t>> worst;
  for (Index o = 0; o < n_output; ++o)
    if (!node.prescribed[static_cast<std::size_t>(o)])
      worst.emplace_back(-missing.middleRows(k * o, k).squaredNorm(), static_cast<std::int32_t>(o));
  std::sort(worst.begin(), worst.end());
  for (std::size_t i = 0; i < std::min<std::size_t>(worst.size(), static_cast<std::size_t>(n_near)); ++i)
    mixed.near.push_back(worst[i].second);
  std::sort(mixed.near.begin(), mixed.near.end());
  MatrixXd far = basis, target = node.modes;
  mixed.near_modes.resize(k * static_cast<Index>(mixed.near.size()), node.modes.cols());
  for (std::size_t i = 0; i < mixed.near.size(); ++i)
    mixed.near_modes.middleRows(k * static_cast<Index>(i), k) = node.modes.middleRows(k * mixed.near[i], k);
  const auto without = [&](Index o) {
    far.middleRows(k * o, k).setZero();
    target.middleRows(k * o, k).setZero();
  };
  for (const auto o : mixed.near) without(o);
  for (Index o = 0; o < n_output; ++o)
    if (node.prescribed[static_cast<std::size_t>(o)]) without(o);
  if (basis.cols() > 0) mixed.mixing = least_squares(transposed_product(far, far), transposed_product(far, target));
  return mixed;
}

ModalFit fit_modal(const TrainingTables& tables, const SharedModes& shared, const NodeModes& node, int n_near,
                   int degree, const std::vector<AmplitudeLevel>& levels) {
  ModalFit fit;
  auto& modal = fit.deformation;
  const MatrixXd basis = shared.modes.values();
  const Index k = node.components, n_output = basis.rows() / k;
  const MixedModes mixed = mix_modes(basis, node, n_near);
  modal.near = mixed.near;

  const auto x = scaled_rows(tables, node.row);
  const MatrixXd f = features(x, scaled_rows(tables, shared.centers), shared.shape, degree);
  const AmplitudeProblem problem(f);
  const MatrixXd weights = problem.size.cwiseInverse().asDiagonal() *
                           solve_positive_definite(problem.normal, transposed_product(problem.unit, node.amplitudes));

  modal.weights = scaled_table(weights);
  modal.mixing = scaled_table(mixed.mixing);
  modal.near_modes = scaled_table(mixed.near_modes);

  MatrixXd stored = product(basis, modal.mixing.values());
  const MatrixXd stored_near = modal.near_modes.values();
  for (std::size_t i = 0; i < modal.near.size(); ++i)
    stored.middleRows(k * modal.near[i], k) = stored_near.middleRows(k * static_cast<Index>(i), k);
  for (Index o = 0; o < n_output; ++o)
    if (node.prescribed[static_cast<std::size_t>(o)]) stored.middleRows(k * o, k).setZero();
  fit.truncation_error =
      node.truncation_error + relative_error(product_transposed(node.amplitudes, stored - node.modes), node);
  fit.regression_error =
      relative_error(product_transposed(product(f, modal.weights.values()) - node.amplitudes, stored), node);
  for (const auto& level : levels) fit.levels.push_back(fit_level(tables, level, shared.shape, degree, node, stored));
  return fit;
}

}  // namespace phynness
