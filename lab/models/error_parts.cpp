#include "error_parts.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "modal/multiquadric.hpp"

namespace phynness::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A constant and a symmetric stiffness.
Eigen::Matrix<double, 3, 9> force_tail(const Vector3d& x) {
  Eigen::Matrix<double, 3, 9> t = Eigen::Matrix<double, 3, 9>::Zero();
  t.leftCols<3>().setIdentity();
  t(0, 3) = t(1, 4) = t(2, 5) = x[0];
  t(0, 4) = t(1, 6) = t(2, 7) = x[1];
  t(0, 5) = t(1, 7) = t(2, 8) = x[2];
  return t;
}

/// Coefficients of kernel and tail that interpolate the values.
MatrixXd interpolated(const MatrixXd& kernel, const MatrixXd& tail, const MatrixXd& values) {
  const Index n = kernel.rows(), m = tail.cols();
  MatrixXd system = MatrixXd::Zero(n + m, n + m), right = MatrixXd::Zero(n + m, values.cols());
  system.topLeftCorner(n, n) = kernel;
  system.topRightCorner(n, m) = tail;
  system.bottomLeftCorner(m, n) = tail.transpose();
  right.topRows(n) = values;
  return Eigen::PartialPivLU<MatrixXd>(system).solve(right);
}

/// Rest, followed by the training states.
Eigen::MatrixX3d with_rest(const Eigen::MatrixX3d& x) {
  Eigen::MatrixX3d all = Eigen::MatrixX3d::Zero(x.rows() + 1, 3);
  all.bottomRows(x.rows()) = x;
  return all;
}

class ForceInterpolation {
 public:
  ForceInterpolation(const ForceStates& states, double shape) : _x(with_rest(states.x)), _shape(shape) {
    const Index n = _x.rows();
    MatrixXd kernel(3 * n, 3 * n), tail(3 * n, 9);
    VectorXd values = VectorXd::Zero(3 * n);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) kernel.block<3, 3>(3 * i, 3 * j) = force_kernel(_x.row(i) - _x.row(j), shape);
      tail.middleRows<3>(3 * i) = force_tail(_x.row(i));
      if (i > 0) values.segment<3>(3 * i) = states.force.row(i - 1);
    }
    _coefficients = interpolated(kernel, tail, values);
  }
  Vector3d operator()(const Vector3d& x) const {
    Vector3d f = force_tail(x) * _coefficients.tail<9>();
    for (Index i = 0; i < _x.rows(); ++i)
      f += force_kernel(x - _x.row(i).transpose(), _shape) * _coefficients.segment<3>(3 * i);
    return f;
  }

 private:
  Eigen::MatrixX3d _x;
  double _shape;
  VectorXd _coefficients;
};

class FieldInterpolation {
 public:
  FieldInterpolation(const Eigen::MatrixX3d& x, const MatrixXd& fields, double shape)
      : _x(with_rest(x)), _shape(shape) {
    const Index n = _x.rows();
    MatrixXd kernel(n, n), tail = MatrixXd::Ones(n, 4), values = MatrixXd::Zero(n, fields.cols());
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) kernel(i, j) = multiquadric(_x.row(i) - _x.row(j), shape);
    tail.rightCols<3>() = _x;
    values.bottomRows(n - 1) = fields;
    _coefficients = interpolated(kernel, tail, values);
  }
  VectorXd operator()(const Vector3d& x) const {
    VectorXd features(_x.rows() + 4);
    for (Index i = 0; i < _x.rows(); ++i) features[i] = multiquadric(x - _x.row(i).transpose(), _shape);
    features.tail<4>() << 1, x;
    return _coefficients.transpose() * features;
  }

 private:
  Eigen::MatrixX3d _x;
  double _shape;
  MatrixXd _coefficients;
};

/// Modes and amplitudes as stored, evaluated in double.
class StoredField {
 public:
  StoredField(const Model& model, const ModalDeformation& modal, const std::vector<char>& counts)
      : _modes(model.shared.modes.values() * modal.mixing.values()),
        _weights(modal.weights.values()),
        _shape(model.shared.shape) {
    const MatrixXd near = modal.near_modes.values();
    for (std::size_t i = 0; i < modal.near.size(); ++i)
      _modes.middleRows<3>(3 * modal.near[i]) = near.middleRows<3>(3 * static_cast<Index>(i));
    for (std::size_t o = 0; o < counts.size(); ++o)
      if (!counts[o]) _modes.middleRows<3>(3 * static_cast<Index>(o)).setZero();
    for (const auto row : model.shared.centers)
      _centers.emplace_back(model.displacements.row(row) / model.max_displacement_m);
    _qr.compute(_modes);
  }
  VectorXd amplitudes(const Vector3d& x) const {
    VectorXd f(static_cast<Index>(_centers.size()) + 3);
    for (std::size_t i = 0; i < _centers.size(); ++i)
      f[static_cast<Index>(i)] = anchored_multiquadric(x, _centers[i], _shape);
    f.tail<3>() = x;
    return _weights.transpose() * f;
  }
  VectorXd projected(const VectorXd& field) const { return _qr.solve(field); }
  VectorXd field(const VectorXd& amplitudes) const { return _modes * amplitudes; }

 private:
  MatrixXd _modes, _weights;
  std::vector<Vector3d> _centers;
  double _shape;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> _qr;
};

/// A field without the nodes that the probe itself moves.
VectorXd counted(const double* u, const std::vector<char>& counts) {
  VectorXd field = Eigen::Map<const VectorXd>(u, 3 * static_cast<Index>(counts.size()));
  for (std::size_t o = 0; o < counts.size(); ++o)
    if (!counts[o]) field.segment<3>(3 * static_cast<Index>(o)).setZero();
  return field;
}

double mean_length(const VectorXd& field, const std::vector<char>& counts) {
  double sum = 0;
  for (Index o = 0; o < field.size() / 3; ++o) sum += field.segment<3>(3 * o).norm();
  return sum / static_cast<double>(std::count(counts.begin(), counts.end(), 1));
}

double largest_length(const VectorXd& field) {
  double largest = 0;
  for (Index o = 0; o < field.size() / 3; ++o) largest = std::max(largest, field.segment<3>(3 * o).norm());
  return largest;
}

Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

void parts_of_force(const Model& model, const ActiveNodeModel& node, const NodeFit& fit,
                    const std::vector<ProbedState>& fresh, ErrorParts& parts) {
  const double R = model.max_displacement_m;
  double largest = 0;
  for (const auto& state : fresh) largest = std::max(largest, vector(state.force_FE).norm());
  const double largest_trained = std::sqrt(fit.states.force.rowwise().squaredNorm().maxCoeff());
  const auto force = [&](const Vector3d& x) { return evaluate_force(node.conservative, model.displacements, R, x); };
  for (Index i = 0; i < fit.states.x.rows(); ++i)
    parts.force_regression += (force(fit.states.x.row(i).transpose()) - fit.states.force.row(i).transpose()).norm() /
                              largest_trained / static_cast<double>(fit.states.x.rows());
  const ForceInterpolation limit(fit.states, node.conservative.shape);
  for (const auto& state : fresh) {
    const Vector3d x = vector(state.d) / R, f = vector(state.force_FE);
    parts.force_total += (force(x) - f).norm() / largest / static_cast<double>(fresh.size());
    parts.force_interpolation += (limit(x) - f).norm() / largest / static_cast<double>(fresh.size());
  }
}

void parts_of_field(const Model& model, const StudyNode& data, const NodeFit& fit, const NodeProbes& probes,
                    const LoadedModel& runtime, ErrorParts& parts) {
  const auto& counts = probes.counts;
  const double R = model.max_displacement_m;
  const auto& fresh = probes.states[0];
  const StoredField stored(model, fit.modal.deformation, counts);
  double largest = 0;
  std::vector<VectorXd> truth;
  for (const auto& state : fresh) {
    truth.push_back(counted(state.u_FE.data(), counts));
    largest = std::max(largest, largest_length(truth.back()));
  }
  const auto share = [&](const VectorXd& field) { return mean_length(field, counts) / largest; };

  const auto n = static_cast<Index>(fit.states.row.size());
  const std::size_t n_increments = data.rays.front().status.size(), per_increment = 3 * counts.size();
  MatrixXd fields(n, static_cast<Index>(per_increment));
  double regression = 0, largest_trained = 0;
  for (Index i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(fit.states.row[static_cast<std::size_t>(i)]);
    const double* u = &data.rays[row / n_increments].displacement[per_increment * (row % n_increments)];
    const VectorXd field = counted(u, counts);
    fields.row(i) = field;
    largest_trained = std::max(largest_trained, largest_length(field));
    regression +=
        mean_length(stored.field(stored.amplitudes(fit.states.x.row(i).transpose()) - stored.projected(field)),
                    counts) /
        static_cast<double>(n);
  }
  parts.regression = regression / largest_trained;
  const FieldInterpolation limit(fit.states.x, fields, model.shared.shape);
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    const double weight = 1 / static_cast<double>(fresh.size());
    const Vector3d x = vector(fresh[i].d) / R;
    const VectorXd best = stored.projected(truth[i]), said = stored.amplitudes(x);
    parts.truncation += weight * share(stored.field(best) - truth[i]);
    parts.amplitudes += weight * share(stored.field(said - best));
    parts.total += weight * share(stored.field(said) - truth[i]);
    parts.interpolation += weight * share(limit(x) - truth[i]);
    const Points rows = runtime.respond({data.node}, {fresh[i].d}).displacement_m;
    parts.float_rounding =
        std::max(parts.float_rounding, largest_length(counted(rows.data(), counts) - stored.field(said)) / largest);
  }
}

}  // namespace

std::vector<ErrorParts> error_parts(const StudyData& data, const StudiedModal& studied, const LoadedModel& model,
                                    const std::vector<NodeProbes>& probes) {
  std::vector<ErrorParts> all;
  for (std::size_t i = 0; i < studied.model.nodes.size(); ++i) {
    const auto& node = studied.model.nodes[i];
    const auto fresh =
        std::find_if(probes.begin(), probes.end(), [&](const NodeProbes& p) { return p.node == node.node; });
    const auto of =
        std::find_if(data.probed.begin(), data.probed.end(), [&](const StudyNode& n) { return n.node == node.node; });
    if (fresh == probes.end() || fresh->states[0].empty()) continue;
    ErrorParts parts;
    parts.node = node.node;
    parts.largest_force_N = largest_force_N(of->rays);
    parts.distance_to_fixed_m = std::numeric_limits<double>::infinity();
    const auto& points = data.header.mesh.nodes;
    for (const auto f : data.header.sets.fixed)
      parts.distance_to_fixed_m = std::min(parts.distance_to_fixed_m, (points.row(f) - points.row(node.node)).norm());
    parts_of_force(studied.model, node, studied.fits[i], fresh->states[0], parts);
    parts_of_field(studied.model, *of, studied.fits[i], *fresh, model, parts);
    all.push_back(parts);
  }
  return all;
}

}  // namespace phynness::study
