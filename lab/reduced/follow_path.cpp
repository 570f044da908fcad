// A reduced body (lab/reduced/study.py) that follows tools in real time: a few steps of Newton's method in every
// millisecond, with a stiffness matrix that is several milliseconds old.
//
//   phynness_follow_path PATH.bin [--steps 2 --keep 4]
//
// PATH.bin is written by study.py --path. Prints times of the parts, and errors of the forces against converged ones in
// per cent of the largest force on the way.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <median_time.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

namespace phynness {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;
using Tensor = Eigen::Matrix<double, 9, 9>;

/// Energy, forces and stiffness in the space of the modes; symbols as in study.py.
struct ReducedBody {
  double mu = 0;
  Matrix gradients;    ///< G: (9 points) x modes
  Vector shear, bulk;  ///< w S and w V of the points
  Matrix psi;          ///< points x pressures
  Matrix soft;         ///< inverse of C
};

/// Where tools are in one millisecond: rows (3 tools) x modes, whose products with q are the means under the tools.
struct Moment {
  Matrix rows;
  Vector displacement;
};

struct Path {
  ReducedBody body;
  std::vector<Moment> moments;
};

/// The kinematics of a state, which forces and stiffness share.
class State {
 public:
  explicit State(const ReducedBody& body) : _body(body), _points(body.shear.size()), _inverse(_points) {}

  /// Forces of the modes at q; false where a point is turned inside out.
  bool set(const Vector& q, Vector& forces) {
    _strain.noalias() = _body.gradients * q;
    _J.resize(_points);
    for (Eigen::Index c = 0; c < _points; ++c) {
      const Eigen::Matrix3d F = at(c) + Eigen::Matrix3d::Identity();
      _J[c] = F.determinant();
      if (!(_J[c] > 0)) return false;
      _inverse[static_cast<std::size_t>(c)] = F.inverse().transpose();
    }
    _pressure.noalias() =
        _body.psi * (_body.soft * (_body.psi.transpose() * (_body.bulk.array() * (_J.array() - 1)).matrix()));
    _pressure.array() *= _body.bulk.array() * _J.array();
    _stress.resize(9 * _points);
    for (Eigen::Index c = 0; c < _points; ++c) {
      const double shear = _body.mu * _body.shear[c];
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P =
          shear * (at(c) + Eigen::Matrix3d::Identity()) +
          (_pressure[c] - shear) * _inverse[static_cast<std::size_t>(c)];
      _stress.segment<9>(9 * c) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(P.data());
    }
    forces.noalias() = _body.gradients.transpose() * _stress;
    return true;
  }

  /// Stiffness matrix of the modes at the state that was set last.
  void stiffness(Matrix& K) {
    _turned.resize(_body.gradients.rows(), _body.gradients.cols());
    _volumes.resize(_points, _body.gradients.cols());
    for (Eigen::Index c = 0; c < _points; ++c) {
      const Eigen::Matrix3d& C = _inverse[static_cast<std::size_t>(c)];
      const double shear = _body.mu * _body.shear[c], p = _pressure[c];
      Tensor A;
      Eigen::Matrix<double, 9, 1> change;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          change[3 * i + j] = _body.bulk[c] * _J[c] * C(i, j);
          for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l)
              A(3 * i + j, 3 * k + l) =
                  (shear - p) * C(i, l) * C(k, j) + p * C(i, j) * C(k, l) + (i == k && j == l ? shear : 0);
        }
      const auto G = _body.gradients.middleRows<9>(9 * c);
      _turned.middleRows<9>(9 * c).noalias() = A * G;
      _volumes.row(c).noalias() = change.transpose() * G;
    }
    const Matrix of_pressures = _body.psi.transpose() * _volumes;
    K.noalias() = _body.gradients.transpose() * _turned;
    K.noalias() += of_pressures.transpose() * (_body.soft * of_pressures);
  }

 private:
  Eigen::Matrix3d at(Eigen::Index c) const {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(_strain.data() + 9 * c);
  }

  const ReducedBody& _body;
  Eigen::Index _points;
  std::vector<Eigen::Matrix3d> _inverse;  ///< F^-T
  Vector _strain, _J, _pressure, _stress;
  Matrix _turned, _volumes;
};

/// The body under tools that move.
class Follower {
 public:
  explicit Follower(const ReducedBody& body) : _state(body), _q(Vector::Zero(body.gradients.cols())) {
    _state.set(_q, _forces);
    renew();
  }

  /// One step towards equilibrium, which is kept as short as it takes for all points to remain right side out.
  /// @return the forces of the tools; nothing if no step does
  std::optional<Vector> step(const Moment& moment) {
    const Matrix moved = _factor.solve(moment.rows.transpose());
    const Vector alone = _factor.solve(_forces);
    const Matrix compliance = moment.rows * moved;
    const Vector force = compliance.ldlt().solve(moment.displacement - moment.rows * _q + moment.rows * alone);
    const Vector step = moved * force - alone;
    for (double part = 1; part > 1e-3; part /= 2)
      if (const Vector q = _q + part * step; _state.set(q, _forces)) {
        _q = q;
        return force;
      }
    _state.set(_q, _forces);
    return std::nullopt;
  }

  /// Factorizes the stiffness of the present state; where it is not positive definite, with a multiple of 1.
  void renew() {
    _state.stiffness(_K);
    for (double more = 0; more < 1e3; more = std::max(4 * more, 1e-4)) {
      Matrix K = _K;
      K.diagonal().array() += more * _K.diagonal().mean();
      _factor.compute(K);
      if (_factor.info() == Eigen::Success) return;
    }
    throw std::runtime_error("the stiffness cannot be factorized");
  }

  State& state() { return _state; }
  const Vector& q() const { return _q; }

  /// Norm of the forces that the tools do not balance, over that of the tools' own.
  double unbalanced(const Moment& moment, const Vector& force) const {
    const Vector held = moment.rows.transpose() * force;
    return (_forces - held).norm() / std::max(held.norm(), 1e-30);
  }

 private:
  State _state;
  Vector _q, _forces;
  Matrix _K;
  Eigen::LLT<Matrix> _factor;
};

Path read(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const auto numbers = [&](double* to, Eigen::Index n) {
    in.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(n) * 8);
    if (!in) throw std::runtime_error("the file ends early: " + file);
  };
  double sizes[6];  // points, modes, pressures, rows, moments, mu
  numbers(sizes, 6);
  const auto points = static_cast<Eigen::Index>(sizes[0]), modes = static_cast<Eigen::Index>(sizes[1]),
             pressures = static_cast<Eigen::Index>(sizes[2]), rows = static_cast<Eigen::Index>(sizes[3]);
  Path path;
  path.body = {sizes[5],       Matrix(9 * points, modes), Vector(points),
               Vector(points), Matrix(points, pressures), Matrix(pressures, pressures)};
  auto& b = path.body;
  numbers(b.gradients.data(), b.gradients.size());
  for (auto* v : {&b.shear, &b.bulk}) numbers(v->data(), v->size());
  for (auto* m : {&b.psi, &b.soft}) numbers(m->data(), m->size());
  path.moments.assign(static_cast<std::size_t>(sizes[4]), {Matrix(rows, modes), Vector(rows)});
  for (auto& moment : path.moments) {
    numbers(moment.rows.data(), moment.rows.size());
    numbers(moment.displacement.data(), rows);
  }
  return path;
}

/// Forces of all moments by steps until they are converged.
std::vector<Vector> converged(const Path& path) {
  constexpr int most = 40;
  constexpr double converged_to = 1e-6;  // a tenth of the smallest errors that are compared
  Follower body(path.body);
  std::vector<Vector> forces;
  for (const auto& moment : path.moments) {
    std::optional<Vector> force;
    int n = 0;
    do {
      force = body.step(moment);
      body.renew();
    } while (++n < most && (!force || body.unbalanced(moment, *force) > converged_to));
    if (n == most)
      throw std::runtime_error(fmt::format("moment {} has no converged forces; {:.1g} of them are unbalanced",
                                           forces.size(), force ? body.unbalanced(moment, *force) : 1.0));
    forces.push_back(*force);
  }
  return forces;
}

void run(const std::string& file, int steps, int keep) {
  const Path path = read(file);
  const auto truth = converged(path);
  double largest = 0;
  for (const auto& f : truth) largest = std::max(largest, f.norm());

  Follower body(path.body);
  std::vector<double> errors, microseconds;
  int lost = 0;
  for (std::size_t k = 0; k < path.moments.size(); ++k) {
    std::optional<Vector> force;
    microseconds.push_back(bench::time_of(1, [&](int) {
      if (k % static_cast<std::size_t>(keep) == 0) body.renew();
      for (int n = 0; n < steps; ++n) force = body.step(path.moments[k]);
    }));
    lost += !force;
    if (force) errors.push_back((*force - truth[k]).norm() / largest);
  }
  if (errors.empty()) throw std::runtime_error("no moment has forces");
  std::sort(errors.begin(), errors.end());
  std::sort(microseconds.begin(), microseconds.end());
  const auto at = [](const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  fmt::print("{} moments, {} points, {} modes; {} steps, stiffness of every {} ms\n", path.moments.size(),
             path.body.shear.size(), path.body.gradients.cols(), steps, keep);
  fmt::print("error median {:.2g} %, 99 % {:.2g} %, largest {:.2g} %; {} moments without forces\n",
             100 * at(errors, 0.5), 100 * at(errors, 0.99), 100 * errors.back(), lost);
  fmt::print("processor time in a millisecond: median {:.0f} us, 99 % {:.0f} us\n", at(microseconds, 0.5),
             at(microseconds, 0.99));
  Vector forces;
  Matrix K;
  const double force_us = bench::median_us([&](int) { body.state().set(body.q(), forces); });
  const double stiffness_us = bench::median_us([&](int) { body.state().stiffness(K); });
  const double factor_us = bench::median_us([&](int) { body.renew(); });
  fmt::print("processor time: forces {:.0f} us, stiffness {:.0f} us, with factorization {:.0f} us\n", force_us,
             stiffness_us, factor_us);
}

}  // namespace
}  // namespace phynness

int main(int argc, char** argv) {
  CLI::App app("A reduced body that follows tools in real time");
  std::string file;
  int steps = 2, keep = 4;
  app.add_option("path", file)->required();
  app.add_option("--steps", steps)->check(CLI::Range(1, 100));
  app.add_option("--keep", keep)->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  try {
    phynness::run(file, steps, keep);
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
