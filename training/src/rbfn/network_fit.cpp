#include <cassert>
#include <cmath>
#include <numeric>
#include <phynness/training/network_fit.hpp>

#include "dense_solvers.hpp"
#include "kernels.hpp"
#include "left_out.hpp"
#include "levels.hpp"

namespace phynness {
namespace {

using kernels::block;

/// Center and half range of every column over the given rows; a constant column is not scaled.
void transform_of(const Eigen::MatrixXd& table, const std::vector<std::int32_t>& rows, Eigen::Index at,
                  Eigen::VectorXd& center, Eigen::VectorXd& half_range) {
  for (Eigen::Index k = 0; k < table.cols(); ++k) {
    double low = table(rows[0], k), high = low;
    for (const std::int32_t row : rows) {
      low = std::min(low, table(row, k));
      high = std::max(high, table(row, k));
    }
    center[at + k] = low + (high - low) / 2;
    // Despite the rounding of the center, scaled values must not exceed 1.
    const double half = std::max(high - center[at + k], center[at + k] - low);
    half_range[at + k] = half > 0 && std::isfinite(1 / half) ? half : 1;
  }
}

Eigen::MatrixXd scaled(const Eigen::MatrixXd& table, Eigen::Index at, const RbfNetwork& net) {
  const auto center = net.input_center.segment(at, table.cols()), half = net.input_half_range.segment(at, table.cols());
  return (table.rowwise() - center.transpose()).array().rowwise() / half.transpose().array();
}

/// The two tables of exponentials whose product is the basis column of a center.
class BasisColumns {
 public:
  BasisColumns(const NetworkPoints& points, const RbfNetwork& net)
      : _points(points),
        _displacements(scaled(points.displacements, 0, net)),
        _places(scaled(points.places, points.displacements.cols(), net)),
        _spread(net.spread),
        _a(static_cast<std::size_t>(points.displacements.rows())),
        _b(static_cast<std::size_t>(std::max<Eigen::Index>(points.places.rows(), 1)), 1.0),
        _no_place(points.place.empty() ? points.size() : 0, 0) {}

  void fill(std::int32_t center, double* column) {
    factor(_displacements, _points.displacement[center], _a);
    if (!_points.place.empty()) factor(_places, _points.place[center], _b);
    kernels::product_column(_a.data(), _points.displacement.data(), _b.data(),
                            _points.place.empty() ? _no_place.data() : _points.place.data(), column, _points.size());
  }

  Eigen::VectorXd scaled_point(std::int32_t p) const {
    Eigen::VectorXd x(_points.n_inputs());
    x.head(_displacements.cols()) = _displacements.row(_points.displacement[p]);
    if (!_points.place.empty()) x.tail(_places.cols()) = _places.row(_points.place[p]);
    return x;
  }

 private:
  void factor(const Eigen::MatrixXd& table, std::int32_t center, std::vector<double>& values) const {
    for (Eigen::Index i = 0; i < table.rows(); ++i) {
      double square = 0;
      for (Eigen::Index k = 0; k < table.cols(); ++k) {
        const double t = (table(i, k) - table(center, k)) / _spread;
        square += t * t;
      }
      values[i] = std::exp(-square);
    }
  }

  const NetworkPoints& _points;
  Eigen::MatrixXd _displacements, _places;
  double _spread;
  std::vector<double> _a, _b;
  std::vector<std::int32_t> _no_place;
};

/// Growing thin QR factorization of the basis, of which the first column is the bias. Zero columns are appended up to
/// whole blocks, so that the sweeps have no remainder.
class GrowingQr {
 public:
  GrowingQr(std::size_t n, int max_columns)
      : _n(n),
        _stride((n + 7) / 8 * 8),
        _q((max_columns + block) * _stride, 0.0),
        _r(Eigen::MatrixXd::Zero(max_columns, max_columns)) {}

  int size() const { return _size; }
  double* next() { return &_q[_size * _stride]; }
  const double* column(int k) const { return &_q[k * _stride]; }
  using Columns = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  /// The first k columns.
  Columns columns(int k) const {
    return {_q.data(), static_cast<Eigen::Index>(_n), k, Eigen::OuterStride<>(static_cast<Eigen::Index>(_stride))};
  }
  const Eigen::MatrixXd& r() const { return _r; }

  /// Orthonormalizes next() against the present columns and appends it. @return false if it is dependent; it is cleared
  /// then
  bool accept_next() {
    double* h = next();
    const double before = norm(h);
    Eigen::VectorXd projection = Eigen::VectorXd::Zero(_size + block);
    sweep(h, projection);
    double after = norm(h);
    // After strong cancellation the remainder of a column is not orthogonal; a second sweep corrects this.
    if (after < reorthogonalize_below * before) {
      sweep(h, projection);
      after = norm(h);
    }
    if (!(after > dependence_threshold * before)) {
      std::fill(h, h + _stride, 0.0);
      return false;
    }
    for (std::size_t p = 0; p < _n; ++p) h[p] /= after;
    _r.col(_size).head(_size) = projection.head(_size);
    _r(_size, _size) = after;
    ++_size;
    return true;
  }

 private:
  static constexpr double reorthogonalize_below = 0.05;

  void sweep(double* h, Eigen::VectorXd& projection) {
    double c[block];
    // The block that contains h itself is processed column by column below.
    const int whole = _size / block * block;
    for (int k = 0; k < whole; k += block) {
      kernels::dot_block(column(k), _stride, h, _n, c);
      kernels::subtract_block(column(k), _stride, c, h, _n);
      for (int j = 0; j < block; ++j) projection[k + j] += c[j];
    }
    for (int k = whole; k < _size; ++k) {
      const double* q = column(k);
      double s = 0;
      for (std::size_t p = 0; p < _n; ++p) s += q[p] * h[p];
      for (std::size_t p = 0; p < _n; ++p) h[p] -= s * q[p];
      projection[k] += s;
    }
  }

  double norm(const double* h) const {
    double sum = 0;
    for (std::size_t p = 0; p < _n; ++p) sum += h[p] * h[p];
    return std::sqrt(sum);
  }

  std::size_t _n, _stride;
  std::vector<double> _q;
  Eigen::MatrixXd _r;
  int _size = 0;
};

std::int32_t worst_untried(const std::vector<double>& error, const std::vector<char>& tried) {
  std::int32_t worst = -1;
  double largest = -1;
  for (std::size_t p = 0; p < error.size(); ++p)
    if (error[p] > largest && !tried[p]) {
      largest = error[p];
      worst = static_cast<std::int32_t>(p);
    }
  return worst;
}

/// @param rest, targets  n x 3, scaled
double left_out_error(const GrowingQr::Columns& q, const Eigen::MatrixXd& rest, const Eigen::MatrixXd& targets,
                      const RbfNetwork& net, const NetworkPoints& points, const std::vector<std::int32_t>& group) {
  const Eigen::MatrixXd errors = left_out_of_projection(q, rest, targets, groups_of_equal(group, 1, 0));
  const double sum = (errors * net.output_half_range.asDiagonal()).rowwise().norm().sum();
  const double largest = points.outputs.rowwise().norm().maxCoeff();
  return largest > 0 ? sum / (static_cast<double>(points.size()) * largest) : 0;
}

/// Greedy selection of the centers of a network, and computation of weights for any number of the first centers.
class NetworkBuilder {
 public:
  NetworkBuilder(const NetworkPoints& points, const FitOptions& options, NetworkFit& fit)
      : _points(points),
        _options(options),
        _fit(fit),
        _n(points.size()),
        _max_neurons(static_cast<int>(std::min<std::size_t>(std::max(options.max_neurons, 0), _n))),
        _targets(scaled_targets()),
        _residual(_targets),
        _error(_n),
        _qr(_n, _max_neurons + 1),
        _basis(points, fit.network),
        _z(_max_neurons + 1, 3) {}

  void choose_centers() {
    std::vector<char> tried(_n, 0);
    std::fill(_qr.next(), _qr.next() + _n, 1.0);
    _qr.accept_next();
    project_out();
    int dependent_in_a_row = 0;
    while (static_cast<int>(_fit.centers.size()) < _max_neurons && dependent_in_a_row < max_dependent_in_a_row &&
           _fit.mse.back() > _options.target_mse) {
      const std::int32_t worst = worst_untried(_error, tried);
      if (worst < 0) break;
      tried[worst] = 1;
      _basis.fill(worst, _qr.next());
      if (!_qr.accept_next()) {
        ++dependent_in_a_row;
        continue;
      }
      dependent_in_a_row = 0;
      _fit.centers.push_back(worst);
      project_out();
    }
  }

  void fit_levels() {
    for (int below = _options.n_levels - 1; below >= 0 && _options.n_levels > 1; --below) {
      NetworkLevel& level = _fit.levels.emplace_back();
      const int n_columns = 1 + level_size(_qr.size() - 1, below, least_neurons);
      const Eigen::MatrixXd first = solve(n_columns);
      level.neurons = {first.bottomRows(n_columns - 1), first.row(0).transpose()};
      if (!_options.group.empty())
        level.left_out_error =
            left_out_error(_qr.columns(n_columns), _remainder, _targets, _fit.network, _points, _options.group);
    }
  }

  void fit_all() {
    RbfNetwork& net = _fit.network;
    const int size = _qr.size();
    const Eigen::MatrixXd solution = solve(size);
    net.bias = solution.row(0).transpose();
    net.weights = solution.bottomRows(size - 1);
    net.centers.resize(size - 1, _points.n_inputs());
    for (int k = 0; k + 1 < size; ++k) {
      const std::int32_t p = _fit.centers[k];
      net.centers.row(k) = _basis.scaled_point(p);
      net.center_displacement.push_back(_points.displacement[p]);
      if (!_points.place.empty()) net.center_output.push_back(_points.place[p]);
    }
  }

 private:
  Eigen::MatrixXd scaled_targets() const {
    const RbfNetwork& net = _fit.network;
    Eigen::MatrixXd targets(_n, 3);
    for (int k = 0; k < 3; ++k)
      targets.col(k) = (_points.outputs.col(k).array() - net.output_center[k]) / net.output_half_range[k];
    return targets;
  }

  void project_out() {
    const int k = _qr.size() - 1;
    double c[3];
    kernels::dot_residuals(_qr.column(k), _residual.data(), _n, _n, c);
    const double sum = kernels::update_residuals(_qr.column(k), c, _residual.data(), _n, _error.data(), _n);
    _z.row(k) << c[0], c[1], c[2];
    _fit.mse.push_back(sum / (3 * static_cast<double>(_n)));
  }

  /// Weights of the first columns, starting with the bias; `_remainder` becomes the residual of the targets.
  Eigen::MatrixXd solve(int n_columns) {
    const auto triangle = _qr.r().topLeftCorner(n_columns, n_columns);
    Eigen::MatrixXd solution = solve_upper(triangle, _z.topRows(n_columns));
    // Refinement with the basis itself instead of its factors removes the effect of Gram-Schmidt's rounding on the
    // weights.
    _remainder = _targets.rowwise() - solution.row(0);
    std::vector<double> column(_n);
    for (int k = 1; k < n_columns; ++k) {
      _basis.fill(_fit.centers[k - 1], column.data());
      const Eigen::Map<const Eigen::VectorXd> h(column.data(), static_cast<Eigen::Index>(_n));
      for (int j = 0; j < 3; ++j) _remainder.col(j) -= solution(k, j) * h;
    }
    Eigen::MatrixXd correction(n_columns, 3);
    for (int k = 0; k < n_columns; ++k) {
      double c[3];
      kernels::dot_residuals(_qr.column(k), _remainder.data(), _n, _n, c);
      kernels::update_residuals(_qr.column(k), c, _remainder.data(), _n, _error.data(), _n);
      correction.row(k) << c[0], c[1], c[2];
    }
    solution += solve_upper(triangle, correction);
    return solution;
  }

  const NetworkPoints& _points;
  const FitOptions& _options;
  NetworkFit& _fit;
  std::size_t _n;
  int _max_neurons;
  Eigen::MatrixXd _targets, _residual, _remainder;
  std::vector<double> _error;
  GrowingQr _qr;
  BasisColumns _basis;
  Eigen::MatrixXd _z;
};

void set_scaling(const NetworkPoints& points, RbfNetwork& net) {
  net.input_center.resize(points.n_inputs());
  net.input_half_range.resize(points.n_inputs());
  transform_of(points.displacements, points.displacement, 0, net.input_center, net.input_half_range);
  if (!points.place.empty())
    transform_of(points.places, points.place, points.displacements.cols(), net.input_center, net.input_half_range);
  net.output_center.resize(3);
  net.output_half_range.resize(3);
  std::vector<std::int32_t> all(points.size());
  std::iota(all.begin(), all.end(), 0);
  transform_of(points.outputs, all, 0, net.output_center, net.output_half_range);
}

}  // namespace

NetworkFit fit_network(const NetworkPoints& points, const FitOptions& options) {
  assert(points.size() > 0 && options.spread > 0);
  NetworkFit fit;
  fit.network.spread = options.spread;
  set_scaling(points, fit.network);
  NetworkBuilder builder(points, options, fit);
  builder.choose_centers();
  builder.fit_levels();
  builder.fit_all();
  return fit;
}

Eigen::Vector3d evaluate(const RbfNetwork& net, const Eigen::VectorXd& inputs) {
  Eigen::Vector3d scaled_output = net.bias;
  for (Eigen::Index i = 0; i < net.centers.rows(); ++i) {
    double square = 0;
    for (Eigen::Index k = 0; k < inputs.size(); ++k) {
      const double t = (inputs[k] - net.input_center[k]) / net.input_half_range[k] - net.centers(i, k);
      square += t * t;
    }
    scaled_output += net.weights.row(i).transpose() * std::exp(-square / (net.spread * net.spread));
  }
  return net.output_center + net.output_half_range.cwiseProduct(scaled_output);
}

}  // namespace phynness
